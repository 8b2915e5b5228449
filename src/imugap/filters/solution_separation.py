"""Errors of position that stay: a filter keeps in mind that fixes were doubted, and looks back.

A test of single fixes forgets. A biased stretch that it has once refused pulls at it again with every fix, and a ramp
that creeps never fails it. Here the error of the positions is a state, the *offset*: north, east, down, behind all
others. While the fixes are trusted it is zero and has no variance, and the filter is the plain one.

set aside
    A fix whose position has a statistic (chi-square, as many degrees of freedom as it has components) above the
    quantile of the false-alarm rate is left out, the velocity with it; one such fix is an outlier.
opened
    At the second in a row the offset starts anew, a constant with a variance that stands for knowing nothing. From then
    on positions tell how the vehicle moves, and no longer where it is.
opened in hindsight
    Beside the filter run reserves: copies with an open offset, started one after the other, that have taken no position
    for granted since. Where nothing is wrong, the offset of a reserve less that of the filter is zero-mean with the
    difference of their covariances, since the filter knows all that the reserve knows and more. If chi-square fails on
    that, the filter gives way to the oldest reserve that says so: what has crept in since then is gone. What has crept
    will go on: the offset is from then on a random walk that goes as far in a second as it has, by the mean square,
    come in each second of the reserve.
closed
    Where so many fixes in a row agree with one offset, and that offset with zero, by chi-square again, it is taken for
    zero: an exact measurement. What the fixes meanwhile told of the place comes back with it, through the covariance.
    Where the offset walks, a reserve, whose own does not, is asked, and takes over.

A doubt that lasts costs as many fixes as it lasts. The test of reserves, and that which closes, have the square of the
false-alarm rate of a single fix: who opens an offset by mistake would keep it.

While an offset is open the receiver is in trouble, and its velocities are not taken at its word: their variance is
multiplied by the mean of their normalised squares since, 1 at least, with the first :data:`AGREED` of them taken as 1.

Sources: M. Brenner, Integrated GPS/inertial fault detection availability, Navigation 43 (1996) 111-130 (separation of
solutions); B. Friedland, Treatment of bias in recursive filtering, IEEE Trans. Autom. Control 14 (1969) 359-367; R. K.
Mehra, On the identification of variances and adaptive Kalman filtering, IEEE Trans. Autom. Control 15 (1970) 175-184.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from imugap.filters.error_state import NAVIGATION, measure
from imugap.filters.innovation_gate import ASIDE, FRESH, HELD, OFFSET, TAKEN, chi_square
from imugap.numerics.rotation import kernel

OFFSETS = ("offset_n", "offset_e", "offset_d")
"""Names of the states [m]."""
SHIFT = OFFSET
"""How many they are; they are the last."""
FREE = 1e6
"""Variance of an offset of which nothing is known [m^2]."""
AGREED = 3
"""Fixes that have to agree in a row before an offset is judged."""
RESERVES = 3
"""Filters that take no position for granted since a while."""
STRIKES, AGREEING, OPEN, BEGAN = range(4)
"""What is kept in mind: refused in a row, agreed in a row, whether the offset is open, the fix at which it began."""
SQUARES, COUNT, WALK, SINCE = range(4)
"""Of an open offset: sum of squares of velocities, how many, variance per second [m^2/s], begin of a reserve [s]."""
OPENED, LOOKED_BACK, CLOSED = 1, 2, 3
"""What became of it, as numbers in :data:`imugap.filters.innovation_gate.TURNS`."""


class State(NamedTuple):
    """Where a filter is, or lanes of them, one above the other: the filter first, then its reserves.

    Navigation, errors, covariance; sample in progress; time, begin of a run of failures [s]; what it keeps in mind,
    whole numbers and others.
    """

    navigation: np.ndarray
    errors: np.ndarray
    covariance: np.ndarray
    sample: np.ndarray
    clock: np.ndarray
    memory: np.ndarray
    doubt: np.ndarray

    def copy(self, lanes: int = 1) -> "State":
        """Return the first lane so many times, each with arrays of its own."""
        return State(*(np.repeat(one[:1], lanes, axis=0) for one in self))


@kernel
def lane(states, number):
    """Return the state of one lane."""
    return State(
        states.navigation[number], states.errors[number], states.covariance[number], states.sample[number],
        states.clock[number], states.memory[number], states.doubt[number],
    )  # fmt: skip


@kernel
def fill(target, source):
    """Put one square matrix in place of another, number by number: a slice would take seconds to compile."""
    for i in range(len(source)):
        for j in range(len(source)):
            target[i, j] = source[i, j]


@kernel
def put(source, target):
    """Put one state in place of another."""
    fill(target.covariance, source.covariance)
    for i in range(len(source.navigation)):
        target.navigation[i] = source.navigation[i]
    for s in range(len(source.errors)):
        target.errors[s] = source.errors[s]
    target.sample[0] = source.sample[0]
    for i in range(len(source.clock)):
        target.clock[i] = source.clock[i]
    for i in range(len(source.memory)):
        target.memory[i], target.doubt[i] = source.memory[i], source.doubt[i]


@kernel
def navigation(row):
    """Return position, velocity and quaternion of a row of ten numbers."""
    return (row[0], row[1], row[2]), (row[3], row[4], row[5]), (row[6], row[7], row[8], row[9])


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
def doubt(fix, count, limits, room, record, memory):
    """Say what becomes of the position of a fix by what is kept in mind, and keep this."""
    seen, statistic = 0, 0.0
    for i in range(count):
        if room.present[i] < SHIFT:
            seen += 1
            statistic += room.whitened[i] * room.whitened[i]
    record.turn[fix] = 0
    if seen == 0 or statistic <= limits[seen]:
        if seen > 0:
            memory[STRIKES] = 0
            memory[AGREEING] += 1
        return HELD if memory[OPEN] else TAKEN
    record.doubt[fix] = statistic
    if memory[STRIKES] == 0:
        memory[STRIKES], memory[AGREEING] = 1, 0
        return ASIDE
    memory[STRIKES], memory[AGREEING], memory[OPEN], memory[BEGAN] = 0, 1, 1, fix
    record.turn[fix] = OPENED
    return FRESH


@kernel
def excess(state):
    """Return by how much velocities vary more than they are told to, since the offset is open: 1 at least."""
    if not state.memory[OPEN]:
        return 1.0
    return max((AGREED + state.doubt[SQUARES]) / (AGREED + state.doubt[COUNT]), 1.0)


@kernel
def learn(count, anew, multiple, room, state):
    """Take account of the velocities of a fix whose variances were multiplied; ``anew`` begins with it."""
    if not state.memory[OPEN]:
        return
    if anew:
        state.doubt[SQUARES], state.doubt[COUNT], state.doubt[WALK] = 0.0, 0.0, 0.0
    for i in range(count):
        if room.present[i] >= SHIFT:
            own = room.innovation[i] * room.innovation[i] - room.variance[i, i] + room.noise[i]
            state.doubt[SQUARES] += multiple * own / room.noise[i]
            state.doubt[COUNT] += 1.0


@kernel
def _apart(covariance, errors, known_covariance, known_errors, room):
    """Return how far the offset of a filter is from that of another that knows more: chi-square, SHIFT freedoms."""
    first = len(covariance) - SHIFT
    for i in range(SHIFT):
        room.innovation[i] = errors[first + i - NAVIGATION] - known_errors[first + i - NAVIGATION]
        for j in range(SHIFT):
            room.variance[i, j] = covariance[first + i, first + j] - known_covariance[first + i, first + j]
    return chi_square(room.innovation, room.variance, SHIFT, room.factor, room.whitened)[0]


@kernel
def _chosen(limit, aged, states, room):
    """Return the oldest reserve that tells of an error, or, where the offset walks, of none; 0: none does."""
    main, found = lane(states, 0), 0
    for number in range(1, len(states.memory)):
        one = lane(states, number)
        if not one.memory[OPEN] or one.memory[AGREEING] < AGREED:
            continue
        if main.doubt[WALK] > 0.0:
            statistic = _apart(one.covariance, one.errors, room.work, room.work[0], room)
            told = statistic <= limit and one.clock[0] - one.doubt[SINCE] >= aged
        else:
            told = _apart(one.covariance, one.errors, main.covariance, main.errors, room) > limit
        if told and (found == 0 or one.memory[BEGAN] < states.memory[found, BEGAN]):
            found = number
    return found


@njit(cache=True, error_model="numpy")
def look_back(fix, limit, aged, states, record, room):
    """Give way to a reserve, or close the offset; return whether either was done.

    Parameters
    ----------
    limit
        Of chi-square.
    aged
        Time from which on a reserve may end a walk [s].
    """
    main, size = lane(states, 0), len(room.work)
    for i in range(size):
        for j in range(size):
            room.work[i, j] = 0.0
    chosen, walked = _chosen(limit, aged, states, room), 0.0
    if chosen > 0:
        one, failing = lane(states, chosen), min(main.clock[0], main.clock[1])
        record.doubt[fix] = _apart(one.covariance, one.errors, main.covariance, main.errors, room)
        if main.doubt[WALK] == 0.0:
            for i in range(SHIFT):
                walked += room.innovation[i] * room.innovation[i] / SHIFT
        put(one, main)
        main.clock[1], main.doubt[WALK] = failing, walked / (main.clock[0] - main.doubt[SINCE])
        record.turn[fix] = LOOKED_BACK
    if main.memory[OPEN] and main.memory[AGREEING] >= AGREED and main.doubt[WALK] == 0.0:
        statistic = _apart(main.covariance, main.errors, room.work, room.work[0], room)
        if statistic <= limit:
            _close(main, room)
            record.turn[fix], record.doubt[fix] = CLOSED, statistic
    if record.turn[fix] < LOOKED_BACK:
        return False
    for k in range(main.memory[BEGAN], fix + 1):
        if record.course[k] != ASIDE:
            record.course[k] = FRESH if main.memory[OPEN] else TAKEN
    return True


@kernel
def _close(state, room):
    """Take the offset for zero."""
    nav, row, size = navigation(state.navigation), room.rows[0], len(state.covariance)
    for i in range(size - SHIFT, size):
        row[i], off = 1.0, state.errors[i - NAVIGATION]
        nav, _ = measure(state.covariance, state.errors, row, off, 0.0, room.spread, room.weight, nav, True)
        row[i] = 0.0
    forget(state.covariance, state.errors, 0.0, room.nothing)
    for i in range(3):
        state.navigation[i], state.navigation[3 + i] = nav[0][i], nav[1][i]
    for i in range(4):
        state.navigation[6 + i] = nav[2][i]
    state.memory[OPEN] = 0


@njit(cache=True, error_model="numpy")
def relieve(fix, states, room):
    """Start a reserve from the filter, with an open offset, in place of none or of that which began first."""
    number, begun = 1, states.memory[1, BEGAN] if states.memory[1, OPEN] else -1
    for other in range(2, len(states.memory)):
        one = states.memory[other, BEGAN] if states.memory[other, OPEN] else -1
        if one < begun:
            number, begun = other, one
    reserve = lane(states, number)
    put(lane(states, 0), reserve)
    forget(reserve.covariance, reserve.errors, FREE, room.nothing)
    reserve.memory[STRIKES], reserve.memory[AGREEING], reserve.memory[OPEN] = 0, 0, 1
    reserve.memory[BEGAN], reserve.doubt[SINCE] = fix + 1, reserve.clock[0]
    reserve.doubt[SQUARES], reserve.doubt[COUNT], reserve.doubt[WALK] = 0.0, 0.0, 0.0
