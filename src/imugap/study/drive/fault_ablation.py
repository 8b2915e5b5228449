"""Benefit of each part of the quality control: simulated drives under every scheme, clean and with gross errors."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from scipy.spatial.transform import Rotation

from imugap.filters.error_state import NAVIGATION
from imugap.filters.innovation_gate import ACCEPTED, NO_CONTROL, SCHEMES, QualityControl
from imugap.filters.solution_separation import EVENT_OPENED, EVENT_SEPARATED
from imugap.io.references import reference
from imugap.kinematics.strapdown import POSITION, VELOCITY
from imugap.log import ACCEL, GYRO
from imugap.navigation.drive.vehicle import DriveAssumptions, DriveInputs, DriveSolution, navigate
from imugap.navigation.drive.vehicle_alignment import align
from imugap.simulation.drive import Drive
from imugap.simulation.gnss_faults import OUTAGE, OUTLIER, RAMP, STRETCH, FaultEvent, Faults, event_kinds

CLEAN, CONTAMINATED, LOST = "clean", "contaminated", "lost"
"""Cases: good fixes; all gross errors of the recipe; only a stretch in which the drive begins."""
ALONE = {kind: f"{kind} alone" for kind in (OUTLIER, STRETCH, RAMP, OUTAGE)}
"""Further cases: gross errors of one kind."""
ORACLE, SMOOTHED = "oracle", "smoothed"
"""Schemes: true standard deviations of the gross errors, as from a perfect test; and the smoother with all control."""
PLAIN, WHOLE = "none", "separation"
"""Schemes without control, and with all of it."""
WHEELS = {name: f"{name}, wheels" for name in (PLAIN, WHOLE, SMOOTHED, ORACLE)}
"""Schemes with the constraint of the rear axle; the one without control runs on good fixes only."""
PARTS = {LOST: ("gated", "reset", WHOLE)} | dict.fromkeys(ALONE.values(), ("reset", WHOLE))
"""Cases with some of the schemes."""
CASES = (CLEAN, CONTAMINATED, *PARTS)
ERRORS = ("horizontal", "vertical", "velocity", "tilt", "heading", "gyro", "accel")
"""Scored lengths of error vectors [m, m, m/s, rad, rad, rad/s, m/s^2], the last two of estimated biases."""
EVERY_S = 1.0
"""Interval of the scored instants [s]."""


@dataclass(frozen=True, eq=False)
class AblationRun:
    """Drive under one scheme: solution, fixes, their gross errors, and true sensor errors."""

    solution: DriveSolution
    fixes: pd.DataFrame
    events: tuple[FaultEvent, ...]
    true: pd.DataFrame


@dataclass(frozen=True)
class Ablation:
    """Drives with gross errors, and a filter with the true models of device and receiver."""

    drive: Drive
    faults: Faults

    @classmethod
    def read(cls, path: str | Path) -> "Ablation":
        """Read a recipe that has both."""
        return cls(Drive.read(path), Faults.read(path))

    @property
    def assumptions(self) -> DriveAssumptions:
        """Assumptions of the filter: those of the recipe."""
        receiver = self.drive.receiver
        return DriveAssumptions(
            lever_m=receiver.lever_m,
            time_offset_s=receiver.delay_s,
            scale_std=self.drive.scale_std,
            position_std=receiver.position_std,
            velocity_std=receiver.velocity_std,
        )

    @property
    def rolling(self) -> DriveAssumptions:
        """Assumptions with the constraint of the rear axle."""
        axle = self.drive.axle
        return replace(
            self.assumptions, nonholonomic_std=axle.std_m_per_s, nonholonomic_s=axle.correlation_s, axle_m=axle.arm_m
        )  # fmt: skip

    def runs(
        self, run: int, seed: int, schemes: dict[str, QualityControl] = SCHEMES, cases: tuple[str, ...] = CASES
    ) -> Iterator[tuple[str, str, AblationRun]]:
        """Yield case, scheme and run, for one drive."""
        drive, assumptions = self.drive, self.assumptions
        record, clean, true = drive.record(run, seed), drive.fixes(run, seed), drive.errors(run, seed)
        known = self._cases(clean, run, seed)
        inputs = DriveInputs(record, clean, drive.model, drive.ellipsoid, assumptions)
        start = align(inputs)

        def navigated(
            own: DriveAssumptions, fixes: pd.DataFrame, quality: QualityControl, events: tuple, smooth: bool
        ) -> AblationRun:
            late = bool(events) and events[0].begin < start.time
            begin = align(replace(inputs, fixes=fixes)) if late else start
            given = replace(inputs, fixes=fixes, assumptions=own, quality=quality)
            return AblationRun(navigate(given, begin, smooth), fixes, events, true)

        for case, (fixes, events) in ((case, known[case]) for case in cases):
            for name, quality in schemes.items():
                if name in PARTS.get(case, schemes):
                    yield case, name, navigated(assumptions, fixes, quality, events, False)
                if name == WHOLE or (name, case) == (PLAIN, CLEAN):
                    yield case, WHEELS[name], navigated(self.rolling, fixes, quality, events, False)
            for own, names in ((assumptions, (SMOOTHED, ORACLE)), (self.rolling, (WHEELS[SMOOTHED], WHEELS[ORACLE]))):
                if case in (CLEAN, CONTAMINATED):
                    yield case, names[0], navigated(own, fixes, QualityControl(), events, True)
                if case == CONTAMINATED:
                    with_deviations = self.faults.with_true_deviations(fixes, events)
                    yield case, names[1], navigated(own, with_deviations, NO_CONTROL, events, False)

    def _cases(
        self, clean: pd.DataFrame, run: int, seed: int
    ) -> dict[str, tuple[pd.DataFrame, tuple[FaultEvent, ...]]]:
        """Return the fixes of each case and the gross errors in them."""
        events = self.faults.draw(clean.index.to_numpy(), seed, run)
        known = {CLEAN: (), CONTAMINATED: events}
        known |= {case: tuple(one for one in events if one.kind == kind) for kind, case in ALONE.items()}
        known[LOST] = (self.faults.first(seed, run),)
        return {
            case: (self.faults.apply(clean, some, self.drive.ellipsoid, seed, run) if some else clean, some)
            for case, some in known.items()
        }

    def errors(self, one: AblationRun) -> pd.DataFrame:
        """Return the errors at every :data:`EVERY_S`: ``time``, :data:`ERRORS`, and the kind of the event there."""
        solution = one.solution
        time = np.arange(np.ceil(solution.time[0]) + EVERY_S, solution.time[-1] + 1e-6, EVERY_S)
        rows = np.minimum(np.searchsorted(solution.time, time - 1e-6), len(solution.time) - 1)
        linear, turn = self._navigation(solution, rows)
        true = self._sensors(one, rows)
        sensors = solution.sensors[true.columns].iloc[rows] - true.to_numpy()
        columns = {
            "time": time,
            "horizontal": np.hypot(linear[:, 0], linear[:, 1]),
            "vertical": np.abs(linear[:, 2]),
            "velocity": np.linalg.norm(linear[:, 3:], axis=1),
            "tilt": np.hypot(turn[:, 0], turn[:, 1]),
            "heading": np.abs(turn[:, 2]),
            "gyro": np.linalg.norm(sensors[list(GYRO)], axis=1),
            "accel": np.linalg.norm(sensors[list(ACCEL)], axis=1),
        }
        return pd.DataFrame(columns).assign(event=event_kinds(time, one.events))

    def verdicts(self, one: AblationRun) -> dict[str, float]:
        """Return the decisions of the quality control in a run, and the consistency of the filter.

        ``false`` is the share of components of good fixes that are removed or weighted down, ``missed`` the share of
        bad fixes with all position components accepted, ``closed`` that of fixes with a failing global test, ``doubts``
        the number of opened offsets; ``nis``, ``nees`` and ``nees_sensors`` are means over the fixes per degree of
        freedom.
        """
        record, solution = one.solution.record, one.solution
        bad = event_kinds(solution.fix_time, one.events) != ""
        touched = record.share < 1
        touched[:, :3] |= (record.position_use != ACCEPTED)[:, None]
        linear, turn = self._navigation(solution, solution.fix_row)
        true = self._sensors(one, solution.fix_row)
        sensors = solution.sensors[true.columns].to_numpy()[solution.fix_row] - true.to_numpy()
        whole = np.hstack([linear, turn, sensors])
        parts = {"nees": slice(0, NAVIGATION), "nees_sensors": slice(NAVIGATION, whole.shape[1])}
        return {
            "false": touched[~bad].mean(),
            "missed": (~touched[bad, :3].any(axis=1)).mean() if bad.any() else np.nan,
            "closed": (~record.passed).mean(),
            "resets": int(record.reset.sum()),
            "doubts": int(np.isin(record.offset_event, (EVENT_OPENED, EVENT_SEPARATED)).sum()),
            "nis": record.statistic.sum() / record.freedom.sum(),
            **{name: _nees(whole[:, part], solution.covariances[:, part, part]) for name, part in parts.items()},
        }

    def _navigation(self, solution: DriveSolution, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the errors of position and velocity, shape (rows, 6), and of the attitude, shape (rows, 3)."""
        truth = self.drive.path[0].iloc[self._samples(solution, rows)]
        found = solution.history.navigation[rows]
        linear = found[:, :6] - truth[[*POSITION, *VELOCITY]].to_numpy(float)
        return linear, (Rotation.from_quat(found[:, 6:]) * reference.rotations(truth).inv()).as_rotvec()

    def _sensors(self, one: AblationRun, rows: np.ndarray) -> pd.DataFrame:
        names = [name for name in one.solution.names if name in one.true]
        return one.true[names].iloc[self._samples(one.solution, rows)]

    def _samples(self, solution: DriveSolution, rows: np.ndarray) -> np.ndarray:
        return np.rint(solution.time.to_numpy()[rows] * self.drive.rate_hz).astype(int)


def hide_effect(study: Ablation, path: str | Path, what: str | None, run: int, seed: int) -> DriveInputs:
    """Return the filter inputs of a drive with one unmodelled effect, by its name among the candidates, or None.

    The effects are those of the part ``hidden`` of the recipe at ``path``.
    """
    given, drive = yaml.safe_load(Path(path).read_text())["hidden"], study.drive
    receiver, record = drive.receiver, drive.record(run, seed)
    if what == "time offset":
        receiver = replace(receiver, delay_s=receiver.delay_s + given["delay_s"])
    elif what == "lever arm":
        receiver = replace(receiver, lever_m=tuple(np.add(receiver.lever_m, given["lever_m"]).tolist()))
    elif what == "scale factor":
        record = record.assign(gyro_z=record["gyro_z"] * (1 + given["gyro_z_scale"]))
    fixes = replace(drive, receiver=receiver).fixes(run, seed)
    return DriveInputs(record, fixes, drive.model, drive.ellipsoid, study.assumptions)


def recovery(errors: pd.DataFrame, events: tuple[FaultEvent, ...], limit: float) -> pd.DataFrame:
    """Return the recovery time after each lasting event: until the horizontal error stays below a limit.

    Parameters
    ----------
    errors
        Errors of one run, with ``time`` and ``horizontal``.
    limit
        Horizontal error [m], for three instants.

    Returns
    -------
    pandas.DataFrame
        Columns ``kind``, ``recovery`` [s]; infinite where the drive ends before.
    """
    time, below = errors["time"].to_numpy(), errors["horizontal"].to_numpy() < limit
    steady = below & np.append(below[1:], True) & np.append(below[2:], [True, True])
    rows = []
    for one in (one for one in events if one.end > one.begin):
        after = np.flatnonzero((time >= one.end) & steady)
        rows.append((one.kind, time[after[0]] - one.end if len(after) else np.inf))
    return pd.DataFrame(rows, columns=["kind", "recovery"])


def scores(errors: pd.DataFrame) -> pd.Series:
    """Return the scores of the errors of one run.

    For each of :data:`ERRORS` the root mean square over the run; ``horizontal_95``, the 95th percentile of the
    horizontal error, and ``aided_95``, outages left out; ``gyro_bad``, ``accel_bad``, root mean squares over stretches
    and ramps.
    """
    found = {name: np.sqrt(np.mean(np.square(errors[name]))) for name in ERRORS}
    found["horizontal_95"] = np.quantile(errors["horizontal"], 0.95)
    found["aided_95"] = np.quantile(errors["horizontal"][errors["event"] != OUTAGE], 0.95)
    bad = errors[in_lasting_fault(errors["event"].to_numpy())]
    for name in ("gyro", "accel"):
        found[f"{name}_bad"] = np.sqrt(np.mean(np.square(bad[name]))) if len(bad) else np.nan
    return pd.Series(found)


def in_lasting_fault(kinds: np.ndarray) -> np.ndarray:
    """Return whether each instant lies in a stretch or a ramp, shape (n,)."""
    return ~np.isin(kinds, ["", "outlier", OUTAGE])


def _nees(errors: np.ndarray, covariances: np.ndarray) -> float:
    solved = np.linalg.solve(covariances, errors[..., None])[..., 0]
    return float(np.einsum("ni,ni->n", errors, solved).mean() / errors.shape[1])
