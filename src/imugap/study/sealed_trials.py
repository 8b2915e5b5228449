"""Sealed cases of one axis or few: what discovery answers, and how probable it holds each explanation.

A sealed case has six axes, of which most hide nothing. Here only those with an effect are searched, at the level that
they have in a search of all six, so that many cases are affordable.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from time import process_time

import pandas as pd
from imu_benchmark.sealing import BlindCase, SealedCase, seal

from imugap.discovery.device import Discovery, Settings, discover
from imugap.discovery.posterior import NONE, OTHER, UNKNOWN, ambiguity_set
from imugap.log import AXES, TEMPERATURE, TIME
from imugap.model import ErrorModel

QUIET = "gyro_x"
"""Axis that is searched where the case hides nothing on one."""
SILENT_KINDS = ("nothing", "unknown")
"""Kinds of cases without an effect of the vocabulary."""


@dataclass(frozen=True)
class Place:
    """A place that a report explains, and what is there.

    Attributes
    ----------
    case, kind
        Name and kind of the case.
    name
        Name that the report gives, or the nearest one where it gives none.
    named
        Whether the report gives the name.
    truth
        What is there: the hidden name, :data:`UNKNOWN` for an effect in no catalogue, :data:`NONE` for nothing.
    probabilities
        Probability of each explanation.
    """

    case: str
    kind: str
    name: str
    named: bool
    truth: str
    probabilities: Mapping[str, float]

    @property
    def likeliest(self) -> str:
        """Return the likeliest explanation."""
        return max(self.probabilities, key=self.probabilities.get)

    @property
    def explanation(self) -> str:
        """Return the explanation that is true: :data:`OTHER` for a name that was not among those compared."""
        return self.truth if self.truth in self.probabilities else OTHER

    def row(self) -> dict:
        """Return the place as a row of a table."""
        chosen = ambiguity_set(self.probabilities)
        return {
            "case": self.case,
            "kind": self.kind,
            "name": self.name,
            "named": self.named,
            "truth": self.truth,
            "likeliest": self.likeliest,
            "probability": self.probabilities[self.likeliest],
            "right": self.likeliest == self.explanation,
            "truth_probability": self.probabilities[self.explanation],
            "set_size": len(chosen),
            "in_set": self.explanation in chosen,
        }


@dataclass(frozen=True, eq=False)
class Answer:
    """What discovery answers to a case, and the time that it took [s, of the processor]."""

    case: BlindCase
    key: Mapping
    found: Discovery
    seconds: float

    @property
    def axes(self) -> set[str]:
        """Return the axes with a hidden effect."""
        return {axis for one in self.key["effects"] for axis in one["axes"]}

    @property
    def seen(self) -> bool:
        """Return whether anything was named or withheld."""
        return bool(self.found.findings or self.found.withheld)

    @property
    def right(self) -> bool:
        """Return whether every hidden effect is named, and nothing else."""
        return sorted(one.name for one in self.found.findings) == sorted(one["name"] for one in self.key["effects"])

    def places(self) -> list[Place]:
        """Return every place that the report explains, with what is there."""
        named = [(one.name, set(one.axes), True, one.probabilities) for one in self.found.findings]
        withheld = [(one.name, {one.axis}, False, one.probabilities) for one in self.found.withheld]
        kind = str(self.case.kind)
        return [
            Place(self.case.name, kind, name, sure, self._truth(name, axes), shares)
            for name, axes, sure, shares in (*named, *withheld)
        ]

    def _truth(self, name: str, axes: set[str]) -> str:
        """Return what is hidden on some axes: the effect of a name if it is among it."""
        here = [one["name"] for one in self.key["effects"] if axes & set(one["axes"])]
        if not here:
            return NONE
        if str(self.case.kind) in SILENT_KINDS:
            return UNKNOWN
        return name if name in here else here[0]


def answer(case: BlindCase, recipe: Mapping, settings: Settings) -> Answer:
    """Seal a case, and discover on the axes with a hidden effect.

    The start model is that of the case; the level is that of ``settings`` for all axes together.
    """
    sealed, begin = seal(case, recipe), process_time()
    used = _searched(sealed)
    own = replace(
        settings,
        alpha=settings.alpha * len(used) / len(AXES),
        start=None if sealed.model is None else ErrorModel.from_mapping(sealed.model),
    )
    found = discover([_part(log, used) for log in sealed.logs], own, reference=sealed.reference)
    return Answer(case, sealed.key, found, process_time() - begin)


def _searched(sealed: SealedCase) -> Sequence[str]:
    """Return the axes with a hidden effect; one without, if there is none."""
    hidden = {axis for one in sealed.key["effects"] for axis in one["axes"]} - {TIME}
    return [axis for axis in AXES if axis in hidden] or [QUIET]


def _part(log: pd.DataFrame, axes: Sequence[str]) -> pd.DataFrame:
    return log[[name for name in log if name in axes or name == TEMPERATURE]]
