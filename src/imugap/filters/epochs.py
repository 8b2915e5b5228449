"""Epochs of a filter: each ends after a fixed number of samples, or at a fix, which may lie between two samples.

A sample is the mean over the interval that it ends; it is divided in two where an epoch ends inside the interval.
"""

from typing import NamedTuple

import numpy as np

STAMP_TOLERANCE_S = 1e-6
"""Largest difference of the stamps of a fix and of a sample that are taken as equal [s]."""


class Epochs(NamedTuple):
    """End of each epoch [s], number of its fix or -1, and whether the device is quiet.

    The first row is the start.
    """

    end: np.ndarray
    fix: np.ndarray
    quiet: np.ndarray

    @classmethod
    def of(cls, stamp: np.ndarray, due: np.ndarray, begin: float, longest: float) -> "Epochs":
        """Divide the time from ``begin`` on into epochs of at most ``longest`` [s].

        Parameters
        ----------
        stamp, due
            Stamps of the samples, and times of the fixes [s].
        """
        interval = float(np.median(np.diff(stamp)))
        every = max(int(longest / interval + 1e-6), 1)
        after = int(np.searchsorted(stamp, begin, "right"))
        ends = stamp[after:]
        near = np.clip(np.searchsorted(stamp, due), 1, len(stamp) - 1)
        near = np.where(np.abs(stamp[near - 1] - due) < np.abs(stamp[near] - due), near - 1, near)
        due = np.where(np.abs(stamp[near] - due) <= STAMP_TOLERANCE_S, stamp[near], due)
        end = np.union1d(np.append(ends[every - 1 :: every], stamp[-1]), due)
        fix = np.full(len(end), -1)
        fix[np.searchsorted(end, due)] = np.arange(len(due))
        return cls(np.append(begin, end), np.append(-1, fix), np.zeros(len(end) + 1, bool))
