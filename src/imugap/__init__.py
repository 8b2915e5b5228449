"""Find disagreements of simulated and measured inertial sensors, identify missing effects, add them, measure the gain.

This page is the contract of every module of the package.

Tables
------
Log
    ``pandas.DataFrame``, index ``time`` [s] strictly increasing, any subset (at least one, in this order) of
    ``gyro_x gyro_y gyro_z`` [rad/s] and ``accel_x accel_y accel_z`` [m/s^2], and optionally ``temperature`` [degC].
    Checked once, at reading (:mod:`imugap.log`); the sampling interval is that of the index.
Effect
    A frozen value such as ``WhiteNoise(density=1e-4)`` (:mod:`imugap.effects`): one physical cause of error.
ErrorModel
    An immutable sum of effects for each axis (:mod:`imugap.model`), read from and written to YAML. Effects act in the
    order of the signal chain (:class:`imugap.effects.effect.Stage`); those on the rows and stamps of the log have the
    pseudo-axis ``time``.
Trajectory
    ``pandas.DataFrame``, index ``time`` [s], columns ``north east down`` [m], ``vel_n vel_e vel_d`` [m/s],
    ``roll pitch heading`` [rad] (:mod:`imugap.kinematics.strapdown`).
Reference
    ``pandas.DataFrame``, index ``time`` [s], columns ``quat_x quat_y quat_z quat_w`` (unit quaternion ``quat_nb``,
    scalar last) and ``moving`` (the phase of motion); only instants at which the attitude is known
    (:mod:`imugap.io.reference`).
Fixes
    ``pandas.DataFrame``, index ``time`` [s], columns ``latitude longitude`` [rad], ``height`` [m], optionally
    ``vel_n vel_e vel_d`` [m/s] and standard deviations: the log of a GNSS receiver (:mod:`imugap.io.gnss`).
Solution
    Estimates of attitude and sensor errors over time by a filter, with covariances and innovations
    (:mod:`imugap.navigation.attitude`); of a walk or a drive, a Trajectory with standard deviations in the same columns
    (:mod:`imugap.navigation.pedestrian`, :mod:`imugap.navigation.vehicle`).

Units
-----
SI and radians inside of the package. Other units are converted on input and output (:mod:`imugap.units`), and are
given by a suffix of the name (``rate_deg_per_s``). Densities are square roots of two-sided power spectral
densities per hertz: white noise ``N`` [unit/sqrt(Hz)] has ``S(f) = N^2``, random walk ``K`` [unit/s/sqrt(Hz)] has
``S(f) = K^2/(2 pi f)^2``, flicker ``B`` [unit] has ``S(f) = B^2/(2 pi |f|)``.

Frames and signs
----------------
``b`` body: the axes of the log. ``n`` navigation: north, east, down. ``e`` Earth (WGS-84). ``mat_nb`` turns a vector
given in ``b`` into ``n``. Accelerometers sense specific force: a body at rest with z down reads ``accel_z = -g``.
Errors are always *measured - true* (``error = output - input``); a drift is *navigated - true*; the error of an
attitude is the rotation vector in ``n`` that turns the true into the estimated one.

Randomness
----------
Every random stream has a name (:mod:`imugap.stream`): the seed and a tuple of labels. Adding a run, an axis, an
effect or a model changes no other stream.
"""

__version__ = "0.1.0"
