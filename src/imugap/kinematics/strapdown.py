"""Strapdown navigation: from angular rate and specific force to attitude, velocity and position.

A sample stamped ``t_k`` is the mean of rate and specific force over ``(t_{k-1}, t_k]``. The initial
:class:`NavigationState` belongs to the time of the first sample; that sample, which ended there, enters only as the
history that the corrections for coning and sculling need.

Two mechanisations, each a frozen value:

:class:`Local`
    ``Cdot = C [w x]``, ``vdot = C f + g``, ``pdot = v``: constant gravity, rates of Earth and transport neglected.
:class:`Ellipsoid`
    The full equations in north, east, down on the rotating WGS-84 ellipsoid (Groves 2013, section 5.4).

One epoch is three compiled steps on tuples of floats, :func:`increments`, then :func:`local_step` or
:func:`ellipsoid_step`; filters build on the same steps.

Sources: P. G. Savage, Strapdown inertial navigation integration algorithm design, parts 1 and 2, J. Guidance Control
Dyn. 21 (1998) 19-28 and 208-221; M. B. Ignagni, Efficient class of optimized coning compensation algorithms,
J. Guidance Control Dyn. 19 (1996) 424-429; P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated
Navigation Systems, 2nd ed., 2013.
"""

from dataclasses import astuple, dataclass

import numpy as np
import pandas as pd

from imugap.kinematics import earth
from imugap.log import ACCEL, GYRO, LogError
from imugap.numerics.rotation import (
    add_scaled,
    cross,
    euler_from_quat,
    from_euler,
    kernel,
    mean_over_turn,
    multiply,
    quat_from_rotvec,
    renormalise,
    rotate,
)

POSITION = ("north", "east", "down")
VELOCITY = ("vel_n", "vel_e", "vel_d")
ATTITUDE = ("roll", "pitch", "heading")
COLUMNS = POSITION + VELOCITY + ATTITUDE
GEODETIC = ("latitude", "longitude", "height")


@dataclass(frozen=True)
class NavigationState:
    """Navigation state: position [m], velocity [m/s] in ``n``, attitude (roll, pitch, heading) [rad]."""

    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    attitude: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        """Convert each part to 3 finite floats; ValueError otherwise."""
        for name in ("position", "velocity", "attitude"):
            part = np.asarray(getattr(self, name), dtype=float)
            if part.shape != (3,) or not np.isfinite(part).all():
                raise ValueError(f"{name}: expected 3 finite numbers; found {getattr(self, name)}")
            object.__setattr__(self, name, tuple(part.tolist()))


@dataclass(frozen=True)
class Local:
    """Flat, non-rotating Earth: constant gravity [m/s^2] along down."""

    gravity: float

    def __post_init__(self) -> None:
        """Check that gravity is finite and not negative."""
        if not 0 <= self.gravity < np.inf:
            raise ValueError(f"gravity: expected a finite number >= 0 [m/s^2]; found {self.gravity}")


@dataclass(frozen=True)
class Ellipsoid:
    """Rotating WGS-84 ellipsoid; position is relative to ``latitude``, ``longitude`` [rad] and ``height`` [m].

    North and east are differences of latitude and longitude times the metres per radian at this origin, down is the
    origin's height minus the height: curvilinear coordinates, so that ``down`` is a difference of heights at any
    distance.
    """

    latitude: float
    longitude: float
    height: float

    def __post_init__(self) -> None:
        """Check that the origin is finite and not at a pole, where north is undefined."""
        if not np.isfinite(astuple(self)).all() or abs(self.latitude) >= np.pi / 2:
            raise ValueError(f"origin: expected finite numbers, latitude within +-pi/2 rad; found {self}")

    @property
    def origin(self) -> tuple[float, float, float, float]:
        """Latitude [rad], height [m], metres per radian of latitude and of longitude."""
        return (self.latitude, self.height, *earth.metres_per_radian(self.latitude, self.height))

    def geodetic(self, position: np.ndarray) -> np.ndarray:
        """Return latitude, longitude [rad] and height [m] of positions (north, east, down) [m], shape (..., 3)."""
        _, _, metres_north, metres_east = self.origin
        return np.array(astuple(self)) + position / np.array([metres_north, metres_east, -1.0])


Mechanisation = Local | Ellipsoid


@kernel
def increments(gyro, accel, gyro_before, accel_before, dt, dt_before):
    """Return the rotation vector [rad] and the velocity increment [m/s] of one sample, both in ``b`` at its start.

    ``gyro`` [rad/s] and ``accel`` [m/s^2] are the means over ``dt`` [s], ``*_before`` those of the sample before. A
    constant rate and a constant specific force in ``b`` are integrated exactly. Rate and force that are linear in time
    over the two intervals add ``k w0 x w`` to the rotation vector (coning) and ``k (w0 x f + f0 x w)`` to the velocity
    (sculling), to the lowest order, with ``k = dt^3/6/(dt + dt0)``: for equal intervals 1/12 of the products of the
    increments, as in Savage (1998, parts 1 and 2) and Ignagni (1996).
    """
    weight = dt * dt * dt / (6 * (dt + dt_before))
    coning = cross(gyro_before, gyro)
    rotvec = (
        gyro[0] * dt + weight * coning[0],
        gyro[1] * dt + weight * coning[1],
        gyro[2] * dt + weight * coning[2],
    )
    turned = mean_over_turn(rotvec, (accel[0] * dt, accel[1] * dt, accel[2] * dt))
    sculled = add_scaled(turned, weight, cross(gyro_before, accel))
    return rotvec, add_scaled(sculled, weight, cross(accel_before, gyro))


@kernel
def local_step(position, velocity, quat_nb, rotvec, delta_v, dt, gravity):
    """Return position [m], velocity [m/s] and attitude after one epoch of the :class:`Local` mechanisation.

    ``rotvec`` [rad] and ``delta_v`` [m/s] come from :func:`increments`. The position is the trapezoidal integral of
    velocity, whose error dt^2/12 times the change of acceleration does not accumulate.
    """
    push = rotate(quat_nb, delta_v)
    after = velocity[0] + push[0], velocity[1] + push[1], velocity[2] + (push[2] + gravity * dt)
    position = add_scaled(add_scaled(position, 0.5 * dt, velocity), 0.5 * dt, after)
    return position, after, renormalise(multiply(quat_nb, quat_from_rotvec(rotvec)))


@kernel
def ellipsoid_step(position, velocity, quat_nb, rotvec, delta_v, dt, origin):
    """Return position [m], velocity [m/s] and attitude after one epoch of the :class:`Ellipsoid` mechanisation.

    ``rotvec`` [rad] and ``delta_v`` [m/s] come from :func:`increments`, ``origin`` from :attr:`Ellipsoid.origin`. All
    terms that depend on position and velocity (gravity, the rates of Groves eqs. 2.123 and 5.44, the Coriolis
    acceleration of eq. 5.53) are taken at the middle of the epoch, with the velocity predicted for it. Under the
    velocity increment ``n`` turns by half of its rotation vector (Savage 1998, part 2).
    """
    latitude0, height0, metres_north0, metres_east0 = origin
    latitude = latitude0 + (position[0] + 0.5 * dt * velocity[0]) / metres_north0
    height = height0 - (position[2] + 0.5 * dt * velocity[2])
    rate_ie = earth.earth_rate_n(latitude)
    rate_in = add_scaled(rate_ie, 1.0, earth.transport_rate_n(latitude, height, velocity[0], velocity[1]))

    push = rotate(quat_nb, delta_v)
    push = add_scaled(push, -0.5 * dt, cross(rate_in, push))
    push = push[0], push[1], push[2] + earth.normal_gravity(latitude, height) * dt
    coriolis = cross(add_scaled(rate_in, 1.0, rate_ie), velocity)
    middle = add_scaled(add_scaled(velocity, 0.5, push), -0.5 * dt, coriolis)

    rate_in = add_scaled(rate_ie, 1.0, earth.transport_rate_n(latitude, height, middle[0], middle[1]))
    coriolis = cross(add_scaled(rate_in, 1.0, rate_ie), middle)
    after = add_scaled(add_scaled(velocity, 1.0, push), -dt, coriolis)
    metres_north, metres_east = earth.metres_per_radian(latitude, height)
    position = (
        position[0] + 0.5 * dt * (velocity[0] + after[0]) * metres_north0 * (1 / metres_north),
        position[1] + 0.5 * dt * (velocity[1] + after[1]) * metres_east0 * (1 / metres_east),
        position[2] + 0.5 * dt * (velocity[2] + after[2]),
    )
    turn_n = quat_from_rotvec((-dt * rate_in[0], -dt * rate_in[1], -dt * rate_in[2]))
    return position, after, renormalise(multiply(turn_n, multiply(quat_nb, quat_from_rotvec(rotvec))))


@kernel
def _row(table, k):
    return table[k, 0], table[k, 1], table[k, 2]


@kernel
def _store(path, row, position, velocity, quat_nb):
    euler = euler_from_quat(quat_nb)
    for i in range(3):
        path[row, i], path[row, 3 + i], path[row, 6 + i] = position[i], velocity[i], euler[i]


@kernel
def _integrate(gyro, accel, dt, start, gravity, origin, every, path):
    """Fill ``path`` with every ``every``-th epoch; the type of ``origin`` (None: local) selects the mechanisation."""
    position, velocity, quat_nb = start
    _store(path, 0, position, velocity, quat_nb)
    for row in range(1, len(path)):
        for k in range((row - 1) * every + 1, row * every + 1):
            rotvec, delta_v = increments(
                _row(gyro, k), _row(accel, k), _row(gyro, k - 1), _row(accel, k - 1), dt[k], dt[k - 1]
            )
            if origin is None:
                position, velocity, quat_nb = local_step(position, velocity, quat_nb, rotvec, delta_v, dt[k], gravity)
            else:
                position, velocity, quat_nb = ellipsoid_step(
                    position, velocity, quat_nb, rotvec, delta_v, dt[k], origin
                )
        _store(path, row, position, velocity, quat_nb)


def navigate(
    gyro: np.ndarray,
    accel: np.ndarray,
    dt: float | np.ndarray,
    state: NavigationState,
    mechanisation: Mechanisation,
    every: int = 1,
) -> np.ndarray:
    """Integrate arrays of samples from ``state``, which belongs to the time of the first sample.

    Parameters
    ----------
    gyro, accel
        Mean rate [rad/s] and specific force [m/s^2] over the interval that ends at each sample, shape (..., n, 3).
        Leading axes are runs, navigated one by one.
    dt
        Length of each sample's interval [s], one number or shape (n,).
    state
        Initial state, the same for every run.
    mechanisation
        :class:`Local` or :class:`Ellipsoid`.
    every
        Store the epochs 0, every, 2 every, ...

    Returns
    -------
    numpy.ndarray
        Shape (..., ceil(n/every), 9), columns :data:`COLUMNS`; heading and roll in (-pi, pi].
    """
    gyro, accel = (np.ascontiguousarray(samples, dtype=float) for samples in (gyro, accel))
    dt = _check_samples(gyro, accel, dt, every)
    quat_nb = tuple(from_euler(state.attitude).as_quat().tolist())
    start = state.position, state.velocity, quat_nb
    gravity, origin = (mechanisation.gravity, None) if isinstance(mechanisation, Local) else (0.0, mechanisation.origin)
    count, runs = gyro.shape[-2], gyro.shape[:-2]
    path = np.empty((*runs, -(-count // every), len(COLUMNS)))
    for run in np.ndindex(runs):
        _integrate(gyro[run], accel[run], dt, start, gravity, origin, every, path[run])
    return path


def _check_samples(gyro: np.ndarray, accel: np.ndarray, dt: float | np.ndarray, every: int) -> np.ndarray:
    """Return ``dt`` as an array of shape (n,), or raise a ValueError that says what is wrong with the samples."""
    if gyro.shape != accel.shape or gyro.ndim < 2 or gyro.shape[-1] != 3 or gyro.shape[-2] < 2:
        raise ValueError(f"gyro, accel: expected equal shapes (..., n >= 2, 3); found {gyro.shape}, {accel.shape}")
    for name, samples in (("gyro", gyro), ("accel", accel)):
        if not np.isfinite(samples).all():
            raise ValueError(f"{name}: expected finite numbers; found {np.sum(~np.isfinite(samples))} others")
    if np.shape(dt) not in ((), (gyro.shape[-2],)):
        raise ValueError(f"dt: expected one number or shape ({gyro.shape[-2]},); found {np.shape(dt)}")
    dt = np.full(gyro.shape[-2], dt, dtype=float)
    if not (np.isfinite(dt).all() and (dt > 0).all()):
        raise ValueError(f"dt: expected finite numbers > 0 [s]; found {dt.min()} to {dt.max()}")
    if every < 1:
        raise ValueError(f"every: expected an integer >= 1; found {every}")
    return dt


def trajectory(log: pd.DataFrame, state: NavigationState, mechanisation: Mechanisation, every: int = 1) -> pd.DataFrame:
    """Navigate a log with six axes from ``state`` at the time of its first sample; return a Trajectory.

    The index is every ``every``-th time of the log, the first row is ``state`` itself. The intervals come from the time
    stamps, however irregular. With :class:`Ellipsoid` the columns :data:`GEODETIC` [rad, rad, m] follow.
    """
    gyro, accel = _samples(log, GYRO), _samples(log, ACCEL)
    time = log.index.to_numpy()
    steps = np.diff(time)
    path = navigate(gyro, accel, np.concatenate([steps[:1], steps]), state, mechanisation, every)
    table = pd.DataFrame(path, index=pd.Index(time[::every], name="time"), columns=list(COLUMNS))
    if isinstance(mechanisation, Ellipsoid):
        table[list(GEODETIC)] = mechanisation.geodetic(path[:, :3])
    return table


def level(accel_mean: np.ndarray) -> tuple[float, float]:
    """Return roll and pitch [rad] of a body at rest from its mean specific force [m/s^2], shape (3,).

    Groves eq. 5.101: the specific force at rest points up.
    """
    x, y, z = np.asarray(accel_mean, dtype=float)
    if not 0 < x * x + y * y + z * z < np.inf:
        raise ValueError(f"accel_mean: expected a finite specific force other than zero; found {accel_mean}")
    return float(np.arctan2(-y, -z)), float(np.arctan2(x, np.hypot(y, z)))


def align(log: pd.DataFrame, duration_s: float, heading: float) -> NavigationState:
    """Return the state of a body that rests for the first ``duration_s`` [s] of ``log``: levelled, at the origin.

    ``heading`` [rad] is given, since it is not observable by levelling.
    """
    accel = _samples(log, ACCEL)
    time = log.index.to_numpy() - log.index[0]
    if not 0 < duration_s <= time[-1]:
        raise ValueError(f"duration_s: expected more than 0 and at most {time[-1]} s, the log; found {duration_s}")
    return NavigationState(attitude=(*level(accel[time < duration_s].mean(axis=0)), heading))


def _samples(log: pd.DataFrame, names: tuple[str, ...]) -> np.ndarray:
    missing = [name for name in names if name not in log.columns]
    if missing:
        raise LogError("log", "columns", f"all of {', '.join(names)}", f"no {', '.join(missing)}")
    return log[list(names)].to_numpy()
