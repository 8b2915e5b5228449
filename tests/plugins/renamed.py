"""A chirp and a dead zone under other names: a file of effects as a user writes it."""

from dataclasses import dataclass
from typing import ClassVar

from imugap.effects import Chirp, DeadZone


@dataclass(frozen=True)
class Sweep(Chirp):
    """Linear chirp."""

    name: ClassVar[str] = "sweep"


@dataclass(frozen=True)
class DeadBand(DeadZone):
    """Output that is zero while its input is small."""

    name: ClassVar[str] = "dead_band"
