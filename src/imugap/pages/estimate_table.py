"""Table of the estimates of a log as text, with what its words mean."""

from collections.abc import Iterator

from imugap.analysis.estimate import LogEstimate
from imugap.effects import BiasInstability, WhiteNoise
from imugap.estimation.report import AxisEstimate
from imugap.estimation.result import Identifiability
from imugap.interchange.start_bias import known_biases
from imugap.io.recognition.frame import axes_text
from imugap.pages.shown import number, table_text, with_interval
from imugap.units import habit

SYMBOLS = {
    "density": "N", "density_b": "B", "density_k": "K", "q": "Q", "slope": "R", "std": "std", "correlation_time": "T",
}  # fmt: skip
"""Symbol of a parameter."""
TITLES = ("axis", "effect", "value", "95 % interval", "unit", "in use")
WORDS = {
    Identifiability.IDENTIFIED: "a parameter without another word beside its interval is identified: zero is not in it",
    Identifiability.UPPER_BOUND: "upper bound: the log does not show that the process exists, and allows no more",
    Identifiability.LOWER_BOUND: "lower bound: the log is too short for an upper end",
    Identifiability.UNDETERMINED: "undetermined: the log sets no end",
}
"""What the classes of a parameter mean."""
FLICKER = (
    "B is the level of flicker noise; the floor of its Allan deviation, often called bias instability, is 0.664 B."
)


def text(found: LogEstimate, gravity: float) -> str:
    """Return the table of the estimates, bounds and biases of a log, and notes on its axes and words.

    Parameters
    ----------
    gravity
        Gravity of the site [m/s^2].
    """
    rows = [row for one in found.axes for row in _rows(one, found)] + [*_biases(found, gravity)]
    classes = {one.verdict for axis in found.axes for one, _ in axis.parameters()}
    classes |= {Identifiability.UPPER_BOUND} if found.bounds else set()
    notes = [f"{text[0].upper()}{text[1:]}." for word, text in WORDS.items() if word in classes]
    if any(isinstance(effect, BiasInstability) for one in found.axes for effect in one.fit.model):
        notes.append(FLICKER)
    axes = axes_text(found.frame)
    return "\n".join([*([f"Axes: {axes}."] if axes else []), table_text(TITLES, rows), "", *notes]).rstrip()


def _rows(estimate: AxisEstimate, found: LogEstimate) -> Iterator[list[str]]:
    """Yield the parameters of an axis, and what its log only bounds."""
    for one, unit in estimate.parameters():
        ordinal = f" {one.ordinal}" if one.effect == "gauss_markov" else ""
        name = f"{one.effect}{ordinal} {SYMBOLS.get(one.parameter, one.parameter)}"
        value, interval = with_interval(one.value, one.low, one.high)
        word = "" if one.verdict is Identifiability.IDENTIFIED else f", {one.verdict}"
        yield [estimate.axis, name, value, f"{interval}{word}", unit, habit(one.value, unit)]
    for effect in found.bounds.get(estimate.axis, ()):
        ((name, value),) = effect.parameters().items()
        unit = effect.units(estimate.unit)[name]
        symbol = "N" if isinstance(effect, WhiteNoise) else "K"
        value_text, word = f"< {number(value, 3)}", str(Identifiability.UPPER_BOUND)
        yield [estimate.axis, f"{effect.name} {symbol}", value_text, word, unit, habit(value, unit)]


def _biases(found: LogEstimate, gravity: float) -> Iterator[list[str]]:
    """Yield the constant biases that the log shows."""
    for axis, bias in known_biases(found.levels, gravity).items():
        unit, along = ("m/s^2", " along gravity") if axis == "accel" else ("rad/s", "")
        yield [axis, f"bias{along}", number(bias), "", unit, habit(bias, unit)]
