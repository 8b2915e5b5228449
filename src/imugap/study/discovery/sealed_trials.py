"""Sealed cases of few axes: the answer of discovery to each, at a cost that allows a thousand.

A sealed case has six axes, of which most hide nothing. Here only those with an effect are searched (all, for an effect
on the stamps), each proposal at the level that it has in a search of all six.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import pandas as pd

from imu_benchmark.sealing import BlindCase, SealedCase, seal
from imugap.discovery.device import Discovery, Settings, discover
from imugap.discovery.report import to_mapping
from imugap.log import AXES, TEMPERATURE, TIME
from imugap.model import ErrorModel

QUIET = "gyro_x"
"""Axis that is searched where the case hides nothing."""


@dataclass(frozen=True, eq=False)
class Answer:
    """Key of a sealed case, and the report of discovery on it."""

    key: Mapping
    report: Mapping

    @property
    def seen(self) -> bool:
        """Return whether anything was named, or seen without a name."""
        return bool(self.report["effects"] or self.report["withheld"])

    @property
    def right(self) -> bool:
        """Return whether every hidden effect is named, and nothing else."""
        named, hidden = ([one["name"] for one in some["effects"]] for some in (self.report, self.key))
        return sorted(named) == sorted(hidden)


def answer(case: BlindCase, recipe: Mapping, settings: Settings) -> Answer:
    """Seal a case, and discover on the axes with a hidden effect, or on :data:`QUIET`.

    The start model is that of the case; the level of ``settings`` is that of all axes together.
    """
    sealed = seal(case, recipe)
    return Answer(sealed.key, to_mapping(search(sealed, settings), ()))


def search(sealed: SealedCase, settings: Settings) -> Discovery:
    """Discover on those axes of a sealed case that hide something, as :func:`answer` does."""
    used = _searched(sealed)
    start = None if sealed.model is None else ErrorModel.from_mapping(sealed.model)
    own = replace(settings.of_some_axes(len(used)), start=start)
    return discover([_part(log, used) for log in sealed.logs], own, reference=sealed.reference)


def _searched(sealed: SealedCase) -> Sequence[str]:
    hidden = {axis for one in sealed.key["effects"] for axis in one["axes"]}
    return AXES if TIME in hidden else [axis for axis in AXES if axis in hidden] or [QUIET]


def _part(log: pd.DataFrame, axes: Sequence[str]) -> pd.DataFrame:
    return log[[name for name in log if name in axes or name == TEMPERATURE]]
