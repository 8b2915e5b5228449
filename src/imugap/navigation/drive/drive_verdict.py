"""Verdict on a navigated drive: whether innovations, smoother and outage test agree with what the filter states.

Innovations
    As large as expected, but for a small share that fails the global test.
Smoother
    Smoother less filter has the covariance of the filter less that of the smoother.
Outage test
    The fixes of some windows are withheld; the prediction at their end errs by as much as it states
    (:mod:`imugap.navigation.drive.outages`).
Offsets
    An offset of the positions that the filter opened closes again. One that never does is a contradiction, even where
    the filter gives up the path for the fixes after some time: either side may be the wrong one.

What is stated too small is multiplied by what the tests find: a solution does not state less than it is wrong by.

Source: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, section
5.4.
"""

from dataclasses import dataclass

import numpy as np

from imugap.filters.innovation_gate import CLOSED, OPENED, RESET, SEPARATED, QualityControl
from imugap.navigation.drive.correction import Correction
from imugap.navigation.drive.drive_error_search import FAILING, LARGEST_NIS, InnovationFit, off_path
from imugap.navigation.drive.outages import Outages
from imugap.navigation.drive.vehicle import DriveInputs, DriveSolution

LARGEST_SMOOTHER = 6.0
"""Mean square of smoother less filter over the expected one above which they disagree."""
EXCEPTIONAL = 10 * QualityControl().false_alarm
"""Share of fixes that fail the test of the innovations from which on it is stated."""
SMALLEST_SHARE = 0.05
"""Share of the filter's variance that smoothing has to take for a comparison."""


@dataclass(frozen=True)
class LastingOffset:
    """Offset of the path from the fixes: ``begin``, ``end`` [s], inf for that of the drive, and ``size`` [m]."""

    begin: float
    end: float
    size: float

    def __str__(self) -> str:
        """Return it in words."""
        end = "the end" if self.end == np.inf else f"{self.end:.10g} s"
        return (
            f"from {self.begin:.10g} s to {end} the path lies beside the fixes, by {self.size:.2g} m: these are off, "
            "or earlier ones drew it away"
        )


@dataclass(frozen=True)
class DriveVerdict:
    """Verdict on a drive.

    Attributes
    ----------
    corrections
        What was wrong with the inputs, and what was done.
    fit
        Fit of the innovations.
    smoother, outage
        Mean normalised squares of smoother less filter, and of predictions over withheld stretches, each over its
        degrees of freedom; NaN where there are none.
    outage_limit
        Limit of the outage test.
    offsets
        Times in which the positions of the fixes are taken to be off by an offset that never closes.
    """

    corrections: tuple[Correction, ...]
    fit: InnovationFit
    smoother: float
    outage: float
    outage_limit: float
    offsets: tuple[LastingOffset, ...] = ()

    @property
    def offset_since(self) -> float | None:
        """Time from which on to the end the positions of the fixes are taken to be off by an offset [s], or None."""
        return next((one.begin for one in self.offsets if one.end == np.inf), None)

    @property
    def reasons(self) -> list[str]:
        """What does not agree, in words."""
        found = [one.found for one in self.corrections if not one.explains]
        if self.fit.failing >= FAILING:
            found.append(f"{self.fit.failing:.0%} of the fixes fail the test of the innovations")
        if self.fit.nis >= LARGEST_NIS:
            found.append(f"innovations are {np.sqrt(self.fit.nis):.2g} times as large as stated")
        if self.smoother > LARGEST_SMOOTHER:
            found.append(f"smoother and filter differ by {np.sqrt(self.smoother):.2g} times what is stated")
        if self.outage > self.outage_limit:
            found.append(f"without fixes the path errs by {np.sqrt(self.outage):.2g} times what is stated")
        return found

    @property
    def agrees(self) -> bool:
        """Whether everything agrees as it was given."""
        return not self.corrections and not self.reasons and not self.offsets

    @property
    def factor(self) -> float:
        """Factor on the stated standard deviations, at least 1."""
        if not self.reasons:
            return 1.0
        return float(np.sqrt(np.nanmax([1.0, self.fit.nis, self.smoother, self.outage])))

    def __str__(self) -> str:
        """Return the answer in a line, then what was corrected, and offsets that last, a line each."""
        mended = [one for one in self.corrections if one.explains]
        lines = (self._answer([one.error for one in mended]), *map(str, mended), *map(str, self.offsets))
        return "\n".join(f"{one[0].upper()}{one[1:]}." for one in lines)

    def _answer(self, named: list[str]) -> str:
        """Return whether device and fixes fit in words, and the names of what was corrected."""
        corrected = f", with {', '.join(named)} corrected" if named else ""
        if self.reasons:
            larger = f", and the stated deviations are multiplied by {self.factor:.2g}" if self.factor > 1 else ""
            reasons = "; ".join(self.reasons)
            return f"device and fixes do not agree{corrected}: {reasons}; nothing that was tried corrects it{larger}"
        since = self.offset_since
        whole = "do not agree throughout" if self.offsets else "agree"
        found = f"{whole if since is None else f'agree only until {since:.10g} s'}{self._exceptions()}"
        if named:
            return f"device and fixes do not fit as given: {', '.join(named)}. Corrected, they {found}"
        return f"device and fixes {found}"

    def _exceptions(self) -> str:
        """Return the share of fixes that do not fit, in words; nothing where it may be chance."""
        share = self.fit.failing
        return f", but for {share:.1%} of the fixes, which count less or not at all" if share > EXCEPTIONAL else ""


def judge(
    inputs: DriveInputs,
    corrections: tuple[Correction, ...],
    filtered: DriveSolution,
    smoothed: DriveSolution,
    outages: Outages,
) -> DriveVerdict:
    """Judge the solutions of a drive."""
    smoother, lasting = smoother_test(filtered, smoothed), _lasting_offsets(inputs, filtered, smoothed)
    return DriveVerdict(corrections, InnovationFit.of(filtered), smoother, *outages.test, lasting)


def _lasting_offsets(
    inputs: DriveInputs, filtered: DriveSolution, smoothed: DriveSolution
) -> tuple[LastingOffset, ...]:
    """Return when an offset was open that never closed, but ended in a reset or at the end."""
    events, begin, found = filtered.events, None, []
    for one in events[events["event"].isin((OPENED, SEPARATED, CLOSED, RESET))].itertuples():
        if one.event in (OPENED, SEPARATED):
            begin = one.time if begin is None else begin
        elif begin is not None:
            if one.event == RESET:
                found.append((float(begin), float(one.time)))
            begin = None
    if begin is not None:
        found.append((float(begin), np.inf))
    off = np.linalg.norm(off_path(inputs, smoothed), axis=1)
    inside = [(smoothed.fix_time >= begin) & (smoothed.fix_time <= end) for begin, end in found]
    return tuple(LastingOffset(*one, float(np.median(off[rows]))) for one, rows in zip(found, inside, strict=True))


def smoother_test(filtered: DriveSolution, smoothed: DriveSolution) -> float:
    """Return the median normalised square of smoother less filter at the fixes, as a mean square over its freedom."""
    rows = filtered.fix_row
    apart = (smoothed.history.navigation[rows, :2] - filtered.history.navigation[rows, :2]) ** 2
    filter_variance = filtered.history.variances[rows, :2]
    gain = filter_variance - smoothed.history.variances[rows, :2]
    known = gain > SMALLEST_SHARE * filter_variance
    return float(np.median(apart[known] / gain[known]) / 0.455) if known.sum() > 10 else float("nan")
