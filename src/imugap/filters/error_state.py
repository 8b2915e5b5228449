"""Error state of an inertial navigator: covariance prediction, scalar measurement update, feedback, smoother adjoint.

The state is position [m], velocity [m/s] and attitude [rad] in ``n``, then the states of the sensors
(:mod:`imugap.filters.sensor_states`), then any constants. All are *estimated - true*; the attitude error is the
rotation vector in ``n`` that turns the true into the estimated attitude. Estimates are fed back at once, so the error
state itself is always zero (Groves 2013, section 14.2); only its covariance is stored, a symmetric array of shape
(states, states).

The transition over an epoch follows the trapezoidal rule: attitude first, then velocity with the mean attitude error of
the epoch, then position with the mean velocity error. Its error is of third order in the interval. Earth rate and
transport rate are neglected, as in :class:`imugap.kinematics.strapdown.Local`.

Every function is compiled and changes arrays in place; vectors are tuples of floats as in
:mod:`imugap.numerics.rotation`. Sources: P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated
Navigation Systems, 2nd ed., 2013; P. S. Maybeck, Stochastic Models, Estimation, and Control, vol. 1, 1979; G. J.
Bierman, Fixed interval smoothing with discrete measurements, Int. J. Control 18 (1973) 65-75; S. F. Schmidt,
Application of state-space methods to navigation problems, Adv. Control Syst. 3 (1966) 293-340.
"""

from imugap.numerics.rotation import kernel, multiply, quat_from_rotvec, renormalise

NAVIGATION = 9
"""States of position, velocity and attitude."""
POSITION, VELOCITY, ATTITUDE = 0, 3, 6
"""First row of each."""


@kernel
def propagate_navigation(source, target, columns, mat_nb, force_n, dt, axis, sensitivity, shift):
    """Multiply ``source`` by the navigation rows of the transition, and store the product transposed in ``target``.

    Parameters
    ----------
    columns
        Number of columns of ``source`` to multiply; each becomes a row of ``target``.
    mat_nb, force_n
        Mean attitude, and mean specific force in ``n`` [m/s^2], over the epoch.
    dt
        Length of the epoch [s].
    axis
        Axis of each sensor state, 0 to 5, shape (sensor states,); those from 6 on do not act on the navigation.
    sensitivity
        Error of the axis per unit of each state: 1 for a bias, the input for a scale factor.
    shift
        Workspace for the sums over the states of each axis, shape (axes, states).
    """
    for a in range(len(shift)):
        for j in range(columns):
            shift[a, j] = 0.0
    for s in range(len(axis)):
        a, factor = axis[s], dt * sensitivity[s]
        for j in range(columns):
            shift[a, j] += factor * source[NAVIGATION + s, j]
    half = 0.5 * dt
    (c00, c01, c02), (c10, c11, c12), (c20, c21, c22) = mat_nb
    f0, f1, f2 = half * force_n[0], half * force_n[1], half * force_n[2]
    for j in range(columns):
        g0, g1, g2 = shift[0, j], shift[1, j], shift[2, j]
        a0, a1, a2 = shift[3, j], shift[4, j], shift[5, j]
        t0 = source[6, j] - (c00 * g0 + c01 * g1 + c02 * g2)
        t1 = source[7, j] - (c10 * g0 + c11 * g1 + c12 * g2)
        t2 = source[8, j] - (c20 * g0 + c21 * g1 + c22 * g2)
        s0, s1, s2 = source[6, j] + t0, source[7, j] + t1, source[8, j] + t2
        v0 = source[3, j] + (f2 * s1 - f1 * s2) - (c00 * a0 + c01 * a1 + c02 * a2)
        v1 = source[4, j] + (f0 * s2 - f2 * s0) - (c10 * a0 + c11 * a1 + c12 * a2)
        v2 = source[5, j] + (f1 * s0 - f0 * s1) - (c20 * a0 + c21 * a1 + c22 * a2)
        target[j, 0] = source[0, j] + half * (source[3, j] + v0)
        target[j, 1] = source[1, j] + half * (source[4, j] + v1)
        target[j, 2] = source[2, j] + half * (source[5, j] + v2)
        target[j, 3], target[j, 4], target[j, 5] = v0, v1, v2
        target[j, 6], target[j, 7], target[j, 8] = t0, t1, t2


@kernel
def propagate(source, target, columns, mat_nb, force_n, dt, axis, sensitivity, decay_factor, shift):
    """Multiply ``source`` by the transition, and store the product transposed in ``target``, both (states, states).

    Parameters
    ----------
    columns, mat_nb, force_n, dt, axis, sensitivity, shift
        As in :func:`propagate_navigation`.
    decay_factor
        Factor by which each sensor state decays over the epoch.
    """
    propagate_navigation(source, target, columns, mat_nb, force_n, dt, axis, sensitivity, shift)
    for j in range(columns):
        for s in range(len(axis)):
            target[j, NAVIGATION + s] = decay_factor[s] * source[NAVIGATION + s, j]
        for i in range(NAVIGATION + len(axis), len(source)):
            target[j, i] = source[i, j]


@kernel
def predict(covariance, work, mat_nb, force_n, dt, axis, sensitivity, decay_factor, driving_variance, white, shift):
    """Predict the covariance over an epoch; ``work`` is a workspace of its shape.

    Only the navigation rows and columns need the full transition; sensor states decay, constants stay.

    Parameters
    ----------
    mat_nb, force_n, dt, axis, sensitivity, decay_factor, shift
        As in :func:`propagate`.
    driving_variance
        Variance added to each sensor state over the epoch by its driving noise.
    white
        Two-sided PSD of the white noise of the six axes [unit^2/Hz].
    """
    size, sensors, half = len(covariance), len(axis), 0.5 * dt
    propagate_navigation(covariance, work, size, mat_nb, force_n, dt, axis, sensitivity, shift)
    propagate_navigation(work, covariance, NAVIGATION, mat_nb, force_n, dt, axis, sensitivity, shift)
    for row in range(NAVIGATION, size):
        left = decay_factor[row - NAVIGATION] if row < NAVIGATION + sensors else 1.0
        for i in range(NAVIGATION):
            covariance[row, i] = left * work[row, i]
        for i in range(NAVIGATION):
            covariance[i, row] = covariance[row, i]
    for s in range(sensors):
        row, left = NAVIGATION + s, decay_factor[s]
        if left != 1.0:
            for j in range(NAVIGATION, size):
                covariance[row, j] *= left
            for j in range(NAVIGATION, size):
                covariance[j, row] *= left
        covariance[row, row] += driving_variance[s]
    for i in range(3):
        row = mat_nb[i]
        for j in range(3):
            other = mat_nb[j]
            turn = dt * (row[0] * white[0] * other[0] + row[1] * white[1] * other[1] + row[2] * white[2] * other[2])
            push = dt * (row[0] * white[3] * other[0] + row[1] * white[4] * other[1] + row[2] * white[5] * other[2])
            covariance[ATTITUDE + i, ATTITUDE + j] += turn
            covariance[VELOCITY + i, VELOCITY + j] += push
            covariance[POSITION + i, VELOCITY + j] += half * push
            covariance[VELOCITY + j, POSITION + i] += half * push
            covariance[POSITION + i, POSITION + j] += half * half * push


@kernel
def transposed_transition(target, work, mat_nb, force_n, dt, axis, sensitivity, decay_factor, shift):
    """Store the transposed transition in ``target``; arguments as in :func:`propagate` and :func:`predict`."""
    size = len(work)
    for i in range(size):
        for j in range(size):
            work[i, j] = 1.0 if i == j else 0.0
    propagate(work, target, size, mat_nb, force_n, dt, axis, sensitivity, decay_factor, shift)


@kernel
def innovation_variance(covariance, row, noise, cross_covariance):
    """Store ``P h'`` in ``cross_covariance``; return ``h P h' + noise``, the innovation variance of the row ``h``."""
    size = len(row)
    for j in range(size):
        cross_covariance[j] = 0.0
    for i in range(size):
        if row[i] != 0.0:
            for j in range(size):
                cross_covariance[j] += row[i] * covariance[i, j]
    variance = noise
    for j in range(size):
        variance += row[j] * cross_covariance[j]
    return variance


@kernel
def joseph_update(covariance, cross_covariance, gain, variance):
    """Update the covariance with a scalar measurement of any gain (Joseph form, Maybeck 1979, eq. 5-84).

    With h the measurement row, R its noise variance and k the gain, ``(I - k h) P (I - k h)' + k R k'``.

    Parameters
    ----------
    covariance
        P, shape (states, states).
    cross_covariance
        P h', shape (states,).
    gain
        Gain k, shape (states,); the optimal one is ``cross_covariance / variance``.
    variance
        Innovation variance h P h' + R.
    """
    for i in range(len(cross_covariance)):
        left = variance * gain[i] - cross_covariance[i]
        for j in range(len(cross_covariance)):
            covariance[i, j] += left * gain[j] - gain[i] * cross_covariance[j]


@kernel
def correct_navigation(position, velocity, quat_nb, error):
    """Return position, velocity and quaternion corrected by the first nine components of an estimated error."""
    turn = quat_from_rotvec((-error[6], -error[7], -error[8]))
    return (
        (position[0] - error[0], position[1] - error[1], position[2] - error[2]),
        (velocity[0] - error[3], velocity[1] - error[4], velocity[2] - error[5]),
        renormalise(multiply(turn, quat_nb)),
    )


@kernel
def scalar_update(covariance, errors, row, residual, noise, cross_covariance, gain, nav, fed):
    """Update covariance and estimates with a scalar measurement, and feed the correction back.

    Without feedback of the states behind the navigation their gain is zero: they are consider states (Schmidt 1966).
    The covariance is that of the gain in use.

    Parameters
    ----------
    covariance, errors
        P, and the estimates of the states behind the navigation, shape (states - 9,); both are updated in place.
    row, residual, noise
        Measurement row h, innovation (estimated - measured), and noise variance.
    cross_covariance, gain
        Workspaces, shape (states,); ``gain`` holds the gain afterwards.
    nav
        Position, velocity and quaternion.
    fed
        Whether the states behind the navigation are fed back.

    Returns
    -------
    tuple
        Corrected navigation, and innovation variance. The squared residual over it is chi-square with one degree of
        freedom; the sum over successive rows has one degree of freedom per row.
    """
    variance = innovation_variance(covariance, row, noise, cross_covariance)
    scale = 1.0 / variance
    for j in range(len(row)):
        gain[j] = scale * cross_covariance[j] if fed or j < NAVIGATION else 0.0
    joseph_update(covariance, cross_covariance, gain, variance)
    for s in range(len(errors)):
        errors[s] -= residual * gain[NAVIGATION + s]
    for j in range(NAVIGATION):
        cross_covariance[j] = residual * gain[j]
    return correct_navigation(nav[0], nav[1], nav[2], cross_covariance), variance


@kernel
def multiply_matrices(left, right, product):
    """Store the product of two square matrices in ``product``; zeros of ``left``, many in a transition, are skipped."""
    size = len(left)
    for i in range(size):
        for j in range(size):
            product[i, j] = 0.0
        for m in range(size):
            factor = left[i, m]
            if factor != 0.0:
                for j in range(size):
                    product[i, j] += factor * right[m, j]


@kernel
def adjoint_measurement(adjoint, information, row, gain, residual, variance, work):
    """Apply a scalar measurement to the adjoint of the smoother, backward in time (Bierman 1973).

    With h the row, k the gain, y the innovation and S its variance, ``l - h'(k'l + y/S)`` and
    ``(I - k h)' L (I - k h) + h' h/S``.

    Parameters
    ----------
    adjoint, information
        l, shape (states,), and L, shape (states, states): information from the later measurements.
    work
        Workspace, shape (states,).
    """
    size = len(row)
    along, inner = residual / variance, 1.0 / variance
    for i in range(size):
        along += gain[i] * adjoint[i]
        work[i] = 0.0
        for j in range(size):
            work[i] += information[i, j] * gain[j]
        inner += gain[i] * work[i]
    for i in range(size):
        adjoint[i] -= row[i] * along
        for j in range(size):
            information[i, j] += inner * row[i] * row[j] - work[i] * row[j] - row[i] * work[j]


@kernel
def adjoint_transition(adjoint, information, transposed, work):
    """Propagate the adjoint of the smoother back over an epoch; ``transposed`` is the transposed transition."""
    size = len(adjoint)
    multiply_matrices(transposed, information, work)
    for i in range(size):
        for j in range(size):
            information[i, j] = 0.0
            for m in range(size):
                information[i, j] += work[i, m] * transposed[j, m]
    for i in range(size):
        work[0, i] = 0.0
        for m in range(size):
            work[0, i] += transposed[i, m] * adjoint[m]
    for i in range(size):
        adjoint[i] = work[0, i]
