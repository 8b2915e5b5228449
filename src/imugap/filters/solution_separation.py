"""Solution separation: detection of lasting position errors of the fixes by sub-filters.

A test of single fixes has no memory: it accepts a ramp, and tests every fix of a biased stretch anew. Here the position
error of the fixes is a state, the *offset*: north, east, down, the last states. While the fixes are trusted it is zero
with zero variance, and the filter is the plain one.

set aside
    A fix whose position statistic (chi-square, one degree of freedom per component) exceeds the quantile of the
    false-alarm rate is excluded, with its velocity.
offset opened
    At a second such fix in a row the offset restarts as a constant of very large variance. From then on positions
    observe the motion of the vehicle, and not its position.
offset opened by separation
    Sub-filters run beside the main filter: copies with an open offset, started one after the other, that have not used
    absolute positions since. Without faults the difference of the offsets of a sub-filter and of the main filter is
    zero-mean, and its covariance is the difference of their covariances (the main filter uses more information). If
    chi-square fails, the oldest sub-filter with a failing test replaces the main filter. Since a ramp continues, the
    offset is from then on a random walk with the mean square growth per second since the start of the sub-filter.
offset closed
    Where enough fixes in a row agree with the offset, and the offset with zero, by chi-square, it is set to zero: an
    exact measurement. The covariance then restores the position information of the fixes since the opening. Where the
    offset is a random walk, a sub-filter, whose offset is constant, is tested and replaces the main filter.

The tests of separation and of closing have the square of the false-alarm rate of a single fix.

While an offset is open the velocity variances are multiplied by the mean of the normalised squared velocity innovations
since the opening, at least 1, with the first :data:`FIXES_REQUIRED` of them taken as 1.

Sources: M. Brenner, Integrated GPS/inertial fault detection availability, Navigation 43 (1996) 111-130 (separation of
solutions); B. Friedland, Treatment of bias in recursive filtering, IEEE Trans. Autom. Control 14 (1969) 359-367; R. K.
Mehra, On the identification of variances and adaptive Kalman filtering, IEEE Trans. Autom. Control 15 (1970) 175-184.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from imugap.filters.error_state import NAVIGATION, scalar_update
from imugap.filters.innovation_gate import ACCEPTED, EXCLUDED, HELD, OFFSET_STATES, RESTARTED, chi_square
from imugap.numerics.rotation import kernel

POSITION_OFFSETS = ("offset_n", "offset_e", "offset_d")
"""Names of the states [m]."""
UNKNOWN_VARIANCE = 1e6
"""Variance of an unknown offset [m^2]."""
FIXES_REQUIRED = 3
"""Number of fixes in a row that have to agree before an offset is tested."""
SUB_FILTERS = 3
"""Number of sub-filters."""
REJECTIONS, AGREEMENTS, OPEN, FIRST_FIX = range(4)
"""Counters: fixes rejected in a row, fixes agreeing in a row, whether the offset is open, its first fix."""
SQUARES, COUNT, WALK_RATE, STARTED = range(4)
"""Open offset: sum of squared velocity innovations, their number, random walk [m^2/s], start of the sub-filter [s]."""
EVENT_OPENED, EVENT_SEPARATED, EVENT_CLOSED = 1, 2, 3
"""Events of the offset: indices in :data:`imugap.filters.innovation_gate.OFFSET_EVENTS`."""


class FilterState(NamedTuple):
    """State of the main filter and its sub-filters, stacked along the first axis; or of one of them.

    Navigation, errors, covariance; sample in progress; time, and start of the present failures [s]; counters of
    :data:`REJECTIONS` to :data:`FIRST_FIX`; numbers of :data:`SQUARES` to :data:`STARTED`; change of the attitude
    matrix by the last epoch of measurements, shape (3, 3).
    """

    navigation: np.ndarray
    errors: np.ndarray
    covariance: np.ndarray
    sample: np.ndarray
    clock: np.ndarray
    counters: np.ndarray
    offset: np.ndarray
    turn: np.ndarray

    def copy(self, members: int = 1) -> "FilterState":
        """Return copies of the first member."""
        return FilterState(*(np.repeat(one[:1], members, axis=0) for one in self))


@kernel
def member(states, number):
    """Return the state of one filter as views."""
    return FilterState(
        states.navigation[number], states.errors[number], states.covariance[number], states.sample[number],
        states.clock[number], states.counters[number], states.offset[number], states.turn[number],
    )  # fmt: skip


@kernel
def copy_matrix(target, source):
    """Copy a square matrix by elements: a slice would take seconds to compile."""
    for i in range(len(source)):
        for j in range(len(source)):
            target[i, j] = source[i, j]


@kernel
def copy_state(source, target):
    """Copy the state of one filter to another."""
    copy_matrix(target.covariance, source.covariance)
    copy_matrix(target.turn, source.turn)
    for i in range(len(source.navigation)):
        target.navigation[i] = source.navigation[i]
    for s in range(len(source.errors)):
        target.errors[s] = source.errors[s]
    target.sample[0] = source.sample[0]
    for i in range(len(source.clock)):
        target.clock[i] = source.clock[i]
    for i in range(len(source.counters)):
        target.counters[i], target.offset[i] = source.counters[i], source.offset[i]


@kernel
def unpack_navigation(row):
    """Return position, velocity and quaternion from a row of ten numbers."""
    return (row[0], row[1], row[2]), (row[3], row[4], row[5]), (row[6], row[7], row[8], row[9])


@kernel
def restart_offset(covariance, errors, variance, transposed):
    """Restart the offset with a variance; clear its rows of the ``transposed`` transition, unless that is empty."""
    size = len(covariance)
    for i in range(size - OFFSET_STATES, size):
        errors[i - NAVIGATION] = 0.0
        for j in range(size):
            covariance[i, j] = covariance[j, i] = 0.0
        for j in range(len(transposed)):
            transposed[j, i] = 0.0
        covariance[i, i] = variance


@kernel
def classify_position(fix, count, limits, room, record, counters):
    """Decide how to use the position fix, and update the fault hypothesis."""
    seen, statistic = 0, 0.0
    for i in range(count):
        if room.present[i] < OFFSET_STATES:
            seen += 1
            statistic += room.whitened[i] * room.whitened[i]
    record.offset_event[fix] = 0
    if seen == 0 or statistic <= limits[seen]:
        if seen > 0:
            counters[REJECTIONS] = 0
            counters[AGREEMENTS] += 1
        return HELD if counters[OPEN] else ACCEPTED
    record.offset_statistic[fix] = statistic
    if counters[REJECTIONS] == 0:
        counters[REJECTIONS], counters[AGREEMENTS] = 1, 0
        return EXCLUDED
    counters[REJECTIONS], counters[AGREEMENTS], counters[OPEN], counters[FIRST_FIX] = 0, 1, 1, fix
    record.offset_event[fix] = EVENT_OPENED
    return RESTARTED


@kernel
def velocity_inflation(state):
    """Return the factor on the velocity variances while the offset is open, at least 1."""
    if not state.counters[OPEN]:
        return 1.0
    return max((FIXES_REQUIRED + state.offset[SQUARES]) / (FIXES_REQUIRED + state.offset[COUNT]), 1.0)


@kernel
def update_velocity_statistics(count, anew, multiple, room, state):
    """Add the velocities of a fix, whose variances were multiplied, to the statistics; ``anew`` restarts them."""
    if not state.counters[OPEN]:
        return
    if anew:
        state.offset[SQUARES], state.offset[COUNT], state.offset[WALK_RATE] = 0.0, 0.0, 0.0
    for i in range(count):
        if room.present[i] >= OFFSET_STATES:
            own = room.innovation[i] * room.innovation[i] - room.variance[i, i] + room.noise[i]
            state.offset[SQUARES] += multiple * own / room.noise[i]
            state.offset[COUNT] += 1.0


@kernel
def _separation(covariance, errors, known_covariance, known_errors, room):
    """Return the chi-square statistic of the offset of a filter against that of one with more information."""
    first = len(covariance) - OFFSET_STATES
    for i in range(OFFSET_STATES):
        room.innovation[i] = errors[first + i - NAVIGATION] - known_errors[first + i - NAVIGATION]
        for j in range(OFFSET_STATES):
            room.variance[i, j] = covariance[first + i, first + j] - known_covariance[first + i, first + j]
    return chi_square(room.innovation, room.variance, OFFSET_STATES, room.factor, room.whitened)[0]


@kernel
def _selected(limit, aged, states, room):
    """Return the oldest sub-filter that shows an error (or none, if the offset is a random walk); 0 for no such."""
    main, found = member(states, 0), 0
    for number in range(1, len(states.counters)):
        one = member(states, number)
        if not one.counters[OPEN] or one.counters[AGREEMENTS] < FIXES_REQUIRED:
            continue
        if main.offset[WALK_RATE] > 0.0:
            statistic = _separation(one.covariance, one.errors, room.work, room.work[0], room)
            selected = statistic <= limit and one.clock[0] - one.offset[STARTED] >= aged
        else:
            selected = _separation(one.covariance, one.errors, main.covariance, main.errors, room) > limit
        if selected and (found == 0 or one.counters[FIRST_FIX] < states.counters[found, FIRST_FIX]):
            found = number
    return found


@njit(cache=True, error_model="numpy")
def separate_solutions(fix, limit, aged, states, record, room):
    """Replace the main filter by a sub-filter, or close the offset; return whether either was done.

    Parameters
    ----------
    limit
        Limit of chi-square.
    aged
        Age from which on a sub-filter may end a random walk of the offset [s].
    """
    main, size = member(states, 0), len(room.work)
    for i in range(size):
        for j in range(size):
            room.work[i, j] = 0.0
    chosen, walked = _selected(limit, aged, states, room), 0.0
    if chosen > 0:
        one, failing = member(states, chosen), min(main.clock[0], main.clock[1])
        record.offset_statistic[fix] = _separation(one.covariance, one.errors, main.covariance, main.errors, room)
        if main.offset[WALK_RATE] == 0.0:
            for i in range(OFFSET_STATES):
                walked += room.innovation[i] * room.innovation[i] / OFFSET_STATES
        copy_state(one, main)
        main.clock[1], main.offset[WALK_RATE] = failing, walked / (main.clock[0] - main.offset[STARTED])
        record.offset_event[fix] = EVENT_SEPARATED
    if main.counters[OPEN] and main.counters[AGREEMENTS] >= FIXES_REQUIRED and main.offset[WALK_RATE] == 0.0:
        statistic = _separation(main.covariance, main.errors, room.work, room.work[0], room)
        if statistic <= limit:
            _close_offset(main, room)
            record.offset_event[fix], record.offset_statistic[fix] = EVENT_CLOSED, statistic
    if record.offset_event[fix] < EVENT_SEPARATED:
        return False
    for k in range(main.counters[FIRST_FIX], fix + 1):
        if record.position_use[k] != EXCLUDED:
            record.position_use[k] = RESTARTED if main.counters[OPEN] else ACCEPTED
    return True


@kernel
def _close_offset(state, room):
    """Set the offset to zero by an exact measurement."""
    nav, row, size = unpack_navigation(state.navigation), room.rows[0], len(state.covariance)
    for i in range(size - OFFSET_STATES, size):
        row[i], off = 1.0, state.errors[i - NAVIGATION]
        nav, _ = scalar_update(
            state.covariance, state.errors, row, off, 0.0, room.cross_covariance, room.gain, nav, True
        )
        row[i] = 0.0
    restart_offset(state.covariance, state.errors, 0.0, room.nothing)
    for i in range(3):
        state.navigation[i], state.navigation[3 + i] = nav[0][i], nav[1][i]
    for i in range(4):
        state.navigation[6 + i] = nav[2][i]
    state.counters[OPEN] = 0


@njit(cache=True, error_model="numpy")
def start_sub_filter(fix, states, room):
    """Start a sub-filter from the main filter with an open offset, in a free place or in that of the oldest."""
    number, begun = 1, states.counters[1, FIRST_FIX] if states.counters[1, OPEN] else -1
    for other in range(2, len(states.counters)):
        one = states.counters[other, FIRST_FIX] if states.counters[other, OPEN] else -1
        if one < begun:
            number, begun = other, one
    sub_filter = member(states, number)
    copy_state(member(states, 0), sub_filter)
    restart_offset(sub_filter.covariance, sub_filter.errors, UNKNOWN_VARIANCE, room.nothing)
    sub_filter.counters[REJECTIONS], sub_filter.counters[AGREEMENTS], sub_filter.counters[OPEN] = 0, 0, 1
    sub_filter.counters[FIRST_FIX], sub_filter.offset[STARTED] = fix + 1, sub_filter.clock[0]
    sub_filter.offset[SQUARES], sub_filter.offset[COUNT], sub_filter.offset[WALK_RATE] = 0.0, 0.0, 0.0
