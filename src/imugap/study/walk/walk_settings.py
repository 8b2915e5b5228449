"""Settings of a walk that are varied, as multiples of the usual ones: what is chosen when settings are held out."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from imugap.analysis.walk import DEFAULT_MODEL
from imugap.effects import WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.log import ACCEL
from imugap.model import ErrorModel
from imugap.navigation.walk.pedestrian import WalkAssumptions


@dataclass(frozen=True)
class WalkSetting:
    """Assumptions and model of a filter: what is varied, and by which factor."""

    varied: str
    factor: float
    assumptions: WalkAssumptions
    model: ErrorModel = DEFAULT_MODEL


def threshold(usual: WalkAssumptions, factor: float) -> WalkSetting:
    """Multiply the threshold of the detector."""
    limits = {name: factor * getattr(usual.detector, name) for name in ("multiple", "lowest", "highest")}
    return WalkSetting("threshold", factor, replace(usual, detector=replace(usual.detector, **limits)))


def velocity(usual: WalkAssumptions, factor: float) -> WalkSetting:
    """Multiply the velocity of a foot at stance."""
    names = "velocity_std", "motion_std"
    return WalkSetting("velocity", factor, replace(usual, **{one: factor * getattr(usual, one) for one in names}))


def noise(usual: WalkAssumptions, factor: float) -> WalkSetting:
    """Multiply the white noise of the accelerometers."""

    def louder(effect):
        return replace(effect, density=factor * effect.density) if isinstance(effect, WhiteNoise) else effect

    noisy = {axis: AxisModel(tuple(louder(effect) for effect in DEFAULT_MODEL[axis])) for axis in ACCEL}
    return WalkSetting("noise", factor, usual, ErrorModel(dict(DEFAULT_MODEL.axes) | noisy))


def around(usual: WalkAssumptions, factors: Iterable[float]) -> Iterator[WalkSetting]:
    """Yield the usual setting, and each of the three with each of the factors."""
    yield WalkSetting("usual", 1.0, usual)
    for vary in (threshold, velocity, noise):
        yield from (vary(usual, factor) for factor in factors)
