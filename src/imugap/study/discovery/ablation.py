"""Does the name matter? The held-out gain of a named effect against that of the best wrong name.

Both models are fitted to the first part of a log and scored on the rest of it, or on another run, by the log-density of
its samples. The wrong name is the one that fits the log best among those that discovery tried in the place of the name.
"""

from collections.abc import Iterator
from dataclasses import asdict, dataclass

from threadpoolctl import threadpool_limits

from imugap.discovery.axis import part
from imugap.discovery.device import Names
from imugap.discovery.evaluation.held_out import HELD_IN_SHARE
from imugap.discovery.finding import Finding
from imugap.discovery.fit.axis_fit import fit, log_score
from imugap.discovery.fit.start_model import described
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.effects.effect import Effect


@dataclass(frozen=True)
class HeldOutGains:
    """Gains of log-density [nat] on unseen samples over the model without the effect: of the name, of a wrong name."""

    axis: str
    name: str
    rival: str
    gain: float
    rival_gain: float

    @property
    def share(self) -> float:
        """Return the share of the gain of the name that the wrong name has."""
        return self.rival_gain / self.gain

    def row(self) -> dict:
        """Return the comparison as a row of a table."""
        return asdict(self) | {"share": self.share}


def within_log(found: Names) -> Iterator[HeldOutGains]:
    """Yield the comparison of every finding with rivals, on the last part of the log on which it was found."""
    for one in _with_rivals(found):
        sequence = found.record.sequences[one.axes[0]]
        split = int(HELD_IN_SHARE * len(sequence.values))
        yield _compared(one, part(sequence, 0, split), part(sequence, split, len(sequence.values)))


def on_another_run(found: Names, run: dict[str, AxisSequence]) -> Iterator[HeldOutGains]:
    """Yield the comparison of every finding with rivals, on another run of the device, by axis."""
    for one in _with_rivals(found):
        axis = one.axes[0]
        if axis in run and not any(effect.once for effect in one.effects.values()):
            yield _compared(one, found.record.sequences[axis], run[axis])


def _with_rivals(found: Names) -> Iterator[Finding]:
    return (one for one in found.findings if one.rivals and one.axis_effects)


def _compared(one: Finding, seen: AxisSequence, unseen: AxisSequence) -> HeldOutGains:
    """Fit the models with the name, with its best rival and with neither to seen samples, and score unseen ones."""
    rival = max(one.rivals, key=lambda other: other.log_bayes_factor)
    (axis, effect), *_ = one.effects.items()
    without = tuple(other for other in one.axis_effects if other.name != effect.name)

    def score(effects: tuple[Effect, ...]) -> float:
        with threadpool_limits(1):
            return log_score(unseen, fit(seen, described(effects, seen)).description)

    least = score(without)
    return HeldOutGains(axis, one.name, rival.name, score(one.axis_effects) - least, score(rival.effects) - least)
