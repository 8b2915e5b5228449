"""Find disagreements of simulated and measured inertial sensors, identify missing effects, add them, measure the gain.

    import imugap as ig

    log = ig.read("imu.bag")                        # any format; says what it recognised: log.recognised
    print(ig.check(log))                            # usable or not, for what, and the next step
    print(ig.indices(log).table)                    # bias, stability, N, B, K as a data sheet has them, with intervals
    fit = ig.estimate(log)                          # effects of each axis with intervals; fit.table, fit.plot()
    fit.export("kalibr", "imu.yaml")                # or vins, ros, gazebo, kf-gins, imugap
    found = ig.discover(log, model="simulator.yaml")  # what the model lacks; found.model has it
    found.report("found")                           # found/report.html, tables, figures

Every result prints as its verdict, shows itself in a notebook, and has ``plot()`` and ``report(folder)``:

>>> import imugap as ig
>>> log = ig.simulate({"gyro_x": [{"white_noise": {"density": 1e-4}}]}, duration=600, rate=20)
>>> ig.check(log).usable
True
>>> fit = ig.estimate(log)
>>> fit.fits
True
>>> fit.table[["axis", "effect", "parameter", "unit"]].to_numpy().tolist()
[['gyro_x', 'white_noise', 'density', 'rad/s/sqrt(Hz)']]
>>> round(float(fit.table["value"].iloc[0]), 6)  # rad/s/sqrt(Hz)
0.0001

Public are the names below (``dir(imugap)``) and the attributes of what they return: :func:`read`, :func:`simulate`
(:mod:`imugap.api.logs`), :func:`check` (:mod:`imugap.api.checks`), :func:`indices` (:mod:`imugap.api.indices`),
:func:`estimate`, :func:`export` (:mod:`imugap.api.estimates`), :func:`discover` (:mod:`imugap.api.discoveries`),
:func:`walk` (:mod:`imugap.api.walks`), :func:`drive` (:mod:`imugap.api.drives`). A public name that is to go warns
with a DeprecationWarning, which names its successor, for at least one minor version before it goes.

What follows is the contract of every module of the package.

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
    (:mod:`imugap.io.references.reference`).
Fixes
    ``pandas.DataFrame``, index ``time`` [s], columns ``latitude longitude`` [rad], ``height`` [m], optionally
    ``vel_n vel_e vel_d`` [m/s] and standard deviations: the log of a GNSS receiver (:mod:`imugap.io.gnss`).
Solution
    Estimates of attitude and sensor errors over time by a filter, with covariances and innovations
    (:mod:`imugap.navigation.attitude`); of a walk or a drive, a Trajectory with standard deviations in the same columns
    (:mod:`imugap.navigation.walk.pedestrian`, :mod:`imugap.navigation.drive.vehicle`).

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

_PUBLIC = {
    "Characterised": "imugap.api.indices",
    "Checked": "imugap.api.checks",
    "DeviceLog": "imugap.api.logs",
    "Discovered": "imugap.api.discoveries",
    "Driven": "imugap.api.drives",
    "ErrorModel": "imugap.model",
    "Estimated": "imugap.api.estimates",
    "LogError": "imugap.log",
    "Walked": "imugap.api.walks",
    "check": "imugap.api.checks",
    "discover": "imugap.api.discoveries",
    "drive": "imugap.api.drives",
    "estimate": "imugap.api.estimates",
    "export": "imugap.api.estimates",
    "indices": "imugap.api.indices",
    "read": "imugap.api.logs",
    "simulate": "imugap.api.logs",
    "walk": "imugap.api.walks",
}
"""Module of each public name; it is imported when the name is used, for most uses need few of them."""
__all__ = ["__version__", *_PUBLIC]


def __getattr__(name: str) -> object:
    """Return a public name from its module."""
    if name not in _PUBLIC:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    found = getattr(import_module(_PUBLIC[name]), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted(__all__)
