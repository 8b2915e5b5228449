"""Epochs of a filter: each ends after so many samples, or at a fix, wherever this lies between two samples.

A sample is the mean over the interval that it ends, and is taken in two parts where an epoch ends within.
"""

from typing import NamedTuple

import numpy as np

NEAR = 1e-6
"""A fix so near the stamp of a sample belongs to it [s]."""


class Epochs(NamedTuple):
    """Ends of the epochs [s], the number of the fix of each, or -1, and whether the device is known to be quiet.

    The first is the start.
    """

    end: np.ndarray
    fix: np.ndarray
    quiet: np.ndarray

    @classmethod
    def of(cls, stamp: np.ndarray, due: np.ndarray, begin: float, longest: float) -> "Epochs":
        """Return the epochs from ``begin`` on, none longer than ``longest`` [s].

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
        due = np.where(np.abs(stamp[near] - due) <= NEAR, stamp[near], due)
        end = np.union1d(np.append(ends[every - 1 :: every], stamp[-1]), due)
        fix = np.full(len(end), -1)
        fix[np.searchsorted(end, due)] = np.arange(len(due))
        return cls(np.append(begin, end), np.append(-1, fix), np.zeros(len(end) + 1, bool))
