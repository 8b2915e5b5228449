"""Errors of position that stay: a filter keeps in mind that fixes were doubted, and looks back.

A test of single fixes forgets. A biased stretch that it has once refused pulls at it again with every fix, and a ramp
that creeps never fails it. Here the error of the positions is a state, the *offset*: three constants, north, east,
down, behind all others. While the fixes are trusted it is zero and has no variance, and the filter is the plain one.

set aside
    A position whose statistic (chi-square, as many degrees of freedom as it has components) is above the quantile of
    the false-alarm rate is left out; one such fix is an outlier.
opened
    At the second in a row the offset starts anew, with a variance that stands for knowing nothing. From then on
    positions tell how the vehicle moves, and no longer where it is.
opened in hindsight
    Beside the filter run reserves: copies with an open offset, started one after the other, that have taken no position
    for granted since. Where nothing is wrong, offset of a reserve less that of the filter is zero-mean with the
    difference of their covariances, since the filter knows all that the reserve knows and more. If chi-square fails on
    that, the filter gives way to the oldest reserve that says so: what has crept in since then is gone.
closed
    Where so many fixes in a row agree with one offset, and that offset with zero, by chi-square again, it is taken for
    zero: an exact measurement. What the fixes meanwhile told of the place comes back with it, through the covariance.

Sources: M. Brenner, Integrated GPS/inertial fault detection availability, Navigation 43 (1996) 111-130 (separation of
solutions); B. Friedland, Treatment of bias in recursive filtering, IEEE Trans. Autom. Control 14 (1969) 359-367; A. S.
Willsky, H. L. Jones, A generalized likelihood ratio approach to the detection and estimation of jumps in linear
systems, IEEE Trans. Autom. Control 21 (1976) 108-112.
"""

from imugap.error_state import NAVIGATION, measure
from imugap.quality import chi_square
from imugap.rotation import kernel

OFFSETS = ("offset_n", "offset_e", "offset_d")
"""Names of the states [m]."""
SHIFT = len(OFFSETS)
"""How many they are; they are the last."""
FREE = 1e3
"""Standard deviation of an offset of which nothing is known [m]."""
AGREED = 3
"""Fixes that have to agree in a row before an offset is judged."""
import os
POWER=float(os.environ.get('POW','2'))
RESERVES = 3
"""Filters that take no position for granted since a while."""
STRIKES, AGREEING, OPEN, BEGAN = range(4)
"""What a filter keeps in mind: refused in a row, agreed in a row, whether the offset is open, and at which fix."""


@kernel
def forget(covariance, errors, variance, transposed):
    """Start the offset anew, with this variance; ``transposed``, unless empty, is the transition to be told so."""
    size = len(covariance)
    for i in range(size - SHIFT, size):
        errors[i - NAVIGATION] = 0.0
        for j in range(size):
            covariance[i, j] = covariance[j, i] = 0.0
        for j in range(len(transposed)):
            transposed[j, i] = 0.0
        covariance[i, i] = variance


@kernel
def apart(covariance, errors, known_covariance, known_errors, room):
    """Return how far the offset of a filter is from that of another that knows more: chi-square, SHIFT freedoms.

    Parameters
    ----------
    covariance, errors
        Of the filter that knows less.
    known_covariance, known_errors
        Of the other.
    room
        Three arrays: innovation, variance, factor and whitened of :func:`imugap.quality.chi_square`.
    """
    innovation, variance, factor, whitened = room
    first = len(covariance) - SHIFT
    for i in range(SHIFT):
        innovation[i] = errors[first + i - NAVIGATION] - known_errors[first + i - NAVIGATION]
        for j in range(SHIFT):
            variance[i, j] = covariance[first + i, first + j] - known_covariance[first + i, first + j]
    return chi_square(innovation, variance, SHIFT, factor, whitened)[0]


@kernel
def close(covariance, errors, nav, row, spread, weight):
    """Take the offset for zero and return the corrected navigation; ``row`` is empty before and after."""
    size = len(covariance)
    for i in range(size - SHIFT, size):
        row[i] = 1.0
        nav, _ = measure(covariance, errors, row, errors[i - NAVIGATION], 0.0, spread, weight, nav, True)
        row[i] = 0.0
    return nav
