"""Recorded drives: fixes of a survey degraded to those of a standard receiver, outages, and a tuned filter.

The survey is the truth. The filter gets its fixes, thinned and with the noise of a standard receiver. The model of the
device comes from the rest before the drive. In motion the errors are larger (vibration, misalignment, scale factor),
and a short rest only bounds the slow ones: white noise and random walks are multiplied by factors that maximise the
likelihood of the innovations of a drive without outages.
"""

from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from imugap.effects import RandomWalk, TurnOnBias, WhiteNoise
from imugap.effects.effect import AxisModel, Effect
from imugap.filters.innovation_gate import NO_CONTROL, SCHEMES, QualityControl
from imugap.filters.solution_separation import EVENT_OPENED, EVENT_SEPARATED
from imugap.io import gnss
from imugap.io.catalogue.public_drives import PublicDrive
from imugap.kinematics.strapdown import ATTITUDE, POSITION
from imugap.log import AXES, GYRO, TRIADS, interval
from imugap.model import ErrorModel
from imugap.navigation.drive.vehicle import AlignmentSettings, DriveAssumptions, DriveInputs, DriveSolution, navigate
from imugap.navigation.drive.vehicle_alignment import align
from imugap.numerics.rotation import from_euler
from imugap.simulation.gnss_faults import FaultEvent, event_kinds
from imugap.stream import stream
from imugap.study.attitude import attitude_schemes
from imugap.study.drive.fault_ablation import SMOOTHED, WHEELS, WHOLE, in_lasting_fault
from imugap.units import to_si

REST_KINDS = (WhiteNoise, RandomWalk)
"""Effects that are fitted to a rest of half a minute."""
SCALE_STD = (0.01, 0.01)
"""Standard deviations of the scale factors of an uncalibrated device."""
TURN_ON = (to_si(0.5, "deg/s"), 0.15)
"""Standard deviations of its constant biases [rad/s] and [m/s^2]."""
WHEELS_STD = 0.2
"""Standard deviation of the velocity across and up with the device instead of the rear axle [m/s]: an arm of 1 m."""
TUNED = ("gyro_white", "accel_white", "gyro_walk", "accel_walk")
"""Tuning factors of a model."""
FACTORS = (2.0**-10, 2.0**6)
"""Limits of the factors."""
GAIN = 0.5
"""Least log-likelihood gain of a change of a factor."""


@dataclass(frozen=True)
class StandardReceiver:
    """Standard receiver: time between fixes [s], standard deviations north, east, down [m] and [m/s]."""

    interval_s: float
    position_std: tuple[float, float, float]
    velocity_std: tuple[float, float, float]

    @classmethod
    def read(cls, path: str | Path, name: str) -> "StandardReceiver":
        """Read the receiver ``name`` of the part ``recorded`` of a recipe (YAML)."""
        given = yaml.safe_load(Path(path).read_text())["recorded"][name]
        return cls(given["interval_s"], tuple(given["position_std"]), tuple(given["velocity_std"]))

    def degrade(self, survey: pd.DataFrame, seed: int, *labels: object) -> pd.DataFrame:
        """Return the fixes of a survey, thinned and with the noise of this receiver."""
        time = survey.index.to_numpy()
        number = np.floor((time - time[0]) / self.interval_s + 1e-6)
        kept = survey[np.append(True, np.diff(number) > 0)]
        ellipsoid = gnss.origin(survey)
        std = np.tile([*self.position_std, *self.velocity_std], (len(kept), 1))
        noise = std * stream(seed, "standard receiver", *labels).standard_normal(std.shape)
        told = np.hypot(std, gnss.deviations(kept, (0.01,) * 3, (0.05,) * 3))
        return gnss.from_local(kept.index.to_numpy(), gnss.local(kept, ellipsoid) + noise, told, ellipsoid)


@dataclass(frozen=True, eq=False)
class DriveTest:
    """PublicDrive, with the assumptions and the alignment settings of the filter."""

    recording: PublicDrive
    assumptions: DriveAssumptions
    alignment: AlignmentSettings

    @property
    def rolling(self) -> "DriveTest":
        """The test with the constraint of the rear axle, which is taken to be at the device."""
        return replace(self, assumptions=replace(self.assumptions, nonholonomic_std=WHEELS_STD))

    def navigate(
        self, fixes: pd.DataFrame, model: ErrorModel, quality: QualityControl = NO_CONTROL, smooth: bool = False
    ) -> DriveSolution:
        """Navigate the recording with these fixes; the origin is the first of the recording's own."""
        inputs = DriveInputs(
            self.recording.log, fixes, model, gnss.origin(self.recording.fixes), self.assumptions, quality,
            self.alignment,
        )  # fmt: skip
        return navigate(inputs, align(inputs), smooth)

    def schemes(
        self, fixes: pd.DataFrame, spoilt: pd.DataFrame, events: tuple[FaultEvent, ...], model: ErrorModel
    ) -> tuple[pd.DataFrame, dict[str, pd.DataFrame]]:
        """Navigate with clean and with contaminated fixes under every scheme of quality control.

        The full control also runs with the constraint of the rear axle, with the smoother, and with both.

        Returns
        -------
        tuple
            A row for each scheme: 95th percentiles of the horizontal error, ``clean`` and ``contaminated`` [m], ``nis``
            over its degrees of freedom and ``doubts``, how often an offset was opened, clean, and how far the biases
            are from those of the clean run in stretches and ramps, root mean square, ``gyro`` [rad/s] and ``accel``
            [m/s^2]; and the errors with the spoilt fixes.
        """
        rows, errors = [], {}
        contenders = {name: (self, quality, False) for name, quality in SCHEMES.items()}
        contenders |= {SMOOTHED: (self, QualityControl(), True), WHEELS[WHOLE]: (self.rolling, QualityControl(), False),
                       WHEELS[SMOOTHED]: (self.rolling, QualityControl(), True)}  # fmt: skip
        for name, (test, quality, smooth) in contenders.items():
            good, bad = (test.navigate(some, model, quality, smooth) for some in (fixes, spoilt))
            off, errors[name] = (self.errors(one)[["north", "east"]] for one in (good, bad))
            row = {"scheme": name, "nis": good.record.statistic.sum() / good.record.freedom.sum(),
                   "doubts": int(np.isin(good.record.offset_event, (EVENT_OPENED, EVENT_SEPARATED)).sum())}  # fmt: skip
            for case, one in (("clean", off), ("contaminated", errors[name])):
                row[case] = np.quantile(np.hypot(one["north"], one["east"]), 0.95)
            at = np.arange(np.ceil(good.time[0]), good.time[-1])
            at = at[in_lasting_fault(event_kinds(at, events))]
            one, other = (some.sensors.iloc[np.searchsorted(some.time, at)] for some in (good, bad))
            for triad, axes in TRIADS.items():
                apart = one[list(axes)].to_numpy() - other[list(axes)].to_numpy()
                row[triad] = np.sqrt(np.mean(np.sum(apart**2, axis=1)))
            rows.append(row)
        return pd.DataFrame(rows), errors

    def errors(self, solution: DriveSolution) -> pd.DataFrame:
        """Return the position error of the antenna at the fixes of the survey: ``north``, ``east``, ``down`` [m]."""
        survey = self.recording.fixes
        inside = survey[(survey.index >= solution.time[0]) & (survey.index <= solution.time[-1])]
        euler = solution.trajectory[list(ATTITUDE)].to_numpy()
        antenna = solution.history.navigation[:, :3] + from_euler(euler).apply(np.array(self.assumptions.lever_m))
        true = gnss.local(inside, solution.ellipsoid)
        at = [np.interp(inside.index, solution.time, column) for column in antenna.T]
        return pd.DataFrame(np.column_stack(at) - true[:, :3], index=inside.index, columns=list(POSITION))

    def outage(self, fixes: pd.DataFrame, model: ErrorModel, begin: float, duration: float) -> pd.DataFrame:
        """Navigate through an outage; return the drift at the times of the survey.

        Returns
        -------
        pandas.DataFrame
            Index seconds since the begin; columns ``horizontal`` [m], ``predicted``, its standard deviation (root of
            the sum of the variances north and east), and ``nees``, chi-square with two degrees of freedom.
        """
        end = begin + duration
        solution = self.navigate(fixes[(fixes.index <= begin) | (fixes.index > end)].loc[: end + 5], model)
        off = self.errors(solution).loc[begin : end - 1e-6, ["north", "east"]]
        rows = np.clip(np.searchsorted(solution.time, off.index) - 1, 0, None)
        told, apart = solution.horizontal[rows], off.to_numpy()
        nees = np.einsum("ni,ni->n", apart, np.linalg.solve(told, apart[..., None])[..., 0])
        columns = {
            "horizontal": np.hypot(*apart.T),
            "predicted": np.sqrt(np.trace(told, axis1=1, axis2=2)),
            "nees": nees,
        }
        return pd.DataFrame(columns, index=pd.Index(off.index - begin, name="since"))

    def tune(self, fixes: pd.DataFrame, model: ErrorModel) -> tuple[ErrorModel, pd.DataFrame]:
        """Tune white noise and random walks of both triads by maximum likelihood of the innovations.

        Each of the four factors in turn is doubled or halved while the likelihood increases.

        Returns
        -------
        tuple
            The model, and the steps: columns :data:`TUNED` and ``likelihood``, the logarithm.
        """
        factors = dict.fromkeys(TUNED, 1.0)
        best = self.log_likelihood(fixes, model, factors)
        rows, moved = [factors | {"likelihood": best}], True
        while moved:
            moved = False
            for name, step in product(TUNED, (2.0, 0.5)):
                trial = factors | {name: factors[name] * step}
                while FACTORS[0] <= trial[name] <= FACTORS[1]:
                    found = self.log_likelihood(fixes, model, trial)
                    if found <= best + GAIN:
                        break
                    factors, best, moved = trial, found, True
                    rows.append(factors | {"likelihood": best})
                    trial = factors | {name: factors[name] * step}
        return scaled(model, factors), pd.DataFrame(rows)

    def log_likelihood(self, fixes: pd.DataFrame, model: ErrorModel, factors: dict[str, float]) -> float:
        """Return the log-likelihood of the innovations with the parameters of ``model`` times ``factors``."""
        record = self.navigate(fixes, scaled(model, factors)).record
        return -0.5 * float(np.sum(record.statistic + record.log_det))


def car(recording: PublicDrive, receiver: StandardReceiver) -> DriveTest:
    """Return the test of a drive with a degraded survey."""
    assumptions = DriveAssumptions(
        lever_m=recording.lever_m, scale_std=SCALE_STD, position_std=receiver.position_std,
        velocity_std=receiver.velocity_std,
    )  # fmt: skip
    return DriveTest(recording, assumptions, AlignmentSettings())


def aircraft(recording: PublicDrive, receiver: StandardReceiver) -> DriveTest:
    """Return the test of a flight with its own receiver; it starts while rolling, nearly along its course."""
    assumptions = DriveAssumptions(
        scale_std=SCALE_STD, position_std=receiver.position_std, velocity_std=receiver.velocity_std
    )  # fmt: skip
    return DriveTest(recording, assumptions, AlignmentSettings(speed=2.0, heading_std=0.1))


def model_from_rest(log: pd.DataFrame, until: float) -> ErrorModel:
    """Return the model of a device by likelihood from the rest up to ``until`` [s], with constant biases."""
    rest = log.loc[:until]
    step = interval(rest)
    fits = {axis: attitude_schemes.SCHEMES["likelihood"](rest[axis].to_numpy(), step, REST_KINDS) for axis in AXES}
    believed = attitude_schemes.filter_model(fits)
    return ErrorModel({axis: believed[axis] + TurnOnBias(std=TURN_ON[axis not in GYRO]) for axis in AXES})


def scaled(model: ErrorModel, factors: dict[str, float]) -> ErrorModel:
    """Return the model with white noise and random walks multiplied by the factors named :data:`TUNED`."""
    return ErrorModel({
        axis: AxisModel(tuple(_scaled(effect, "gyro" if axis in GYRO else "accel", factors) for effect in one))
        for axis, one in model.axes.items()
    })  # fmt: skip


def _scaled(effect: Effect, triad: str, factors: dict[str, float]) -> Effect:
    if isinstance(effect, WhiteNoise):
        return replace(effect, density=effect.density * factors[f"{triad}_white"])
    if isinstance(effect, RandomWalk):
        return replace(effect, density_k=effect.density_k * factors[f"{triad}_walk"])
    return effect
