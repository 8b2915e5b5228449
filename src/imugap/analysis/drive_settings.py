"""Settings of a drive: how the device sits in the vehicle, what it errs by, and what is done about fixes.

A configuration is read by a closed schema, ``drive.schema.yaml``; settings that a drive has shown are written in its
keys, so that they can be used for the next one.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import yaml

from imugap.filters.innovation_gate import QualityControl
from imugap.interchange.devices.catalogue import model_file
from imugap.interchange.plugins import catalogue
from imugap.interchange.start_models.catalogue import ModelFile
from imugap.io import configuration
from imugap.io.gnss import PLACE_STD, VELOCITY_STD
from imugap.kinematics.strapdown import ATTITUDE
from imugap.log import ACCEL, GYRO
from imugap.model import ErrorModel
from imugap.navigation.drive import clock_rate
from imugap.navigation.drive.drive_error_search import FACTOR_KEYS
from imugap.navigation.drive.vehicle import AlignmentSettings, DriveAssumptions, DriveInputs

SCHEMA = Path(__file__).with_name("drive.schema.yaml")
CONTROLS = ("robust", "steepness", "false_alarm", "gated", "reset_s")
"""Settings of the quality control of the same name in the configuration."""
GYRO_CLASS = {"white_noise": {"density": 2e-4}, "gauss_markov": {"std": 5e-3, "correlation_time": 3600}}
ACCEL_CLASS = {"white_noise": {"density": 2e-3}, "gauss_markov": {"std": 0.1, "correlation_time": 3600}}
DEFAULT_MODEL = ErrorModel.from_mapping(
    {axis: [GYRO_CLASS] for axis in GYRO} | {axis: [ACCEL_CLASS] for axis in ACCEL}
)  # fmt: skip
"""Error model of an unknown device in a car: that of a cheap device under vibration."""


@dataclass(frozen=True)
class DriveSettings:
    """Configuration of a drive: error model, mounting (Euler angles [rad]), and settings of the filter.

    ``clock_rate`` is the share by which the clock of the device goes slower than that of the fixes; ``recognised`` are
    sentences on a model that is a file of another tool.
    """

    model: ErrorModel = DEFAULT_MODEL
    mounting: tuple[float, float, float] = (0.0, 0.0, 0.0)
    assumptions: DriveAssumptions = field(default_factory=DriveAssumptions)
    quality: QualityControl = field(default_factory=QualityControl)
    alignment: AlignmentSettings = field(default_factory=AlignmentSettings)
    clock_rate: float = 0.0
    recognised: tuple[str, ...] = ()

    @property
    def states_receiver(self) -> bool:
        """Whether the noise of the receiver is stated, and not that by default."""
        plain = DriveAssumptions()
        own = self.assumptions
        stated, default = (
            (one.position_std, one.velocity_std, one.slow_position_std, one.std_factors) for one in (own, plain)
        )
        return stated != default

    @classmethod
    def read(cls, path: str | Path | None, effects: str | None = None) -> "DriveSettings":
        """Read a configuration (YAML, described by ``drive.schema.yaml``); None gives the defaults."""
        values = configuration.configure({}, SCHEMA) if path is None else configuration.read(path, SCHEMA)
        if values["model"] is None:
            return cls.of(values, DEFAULT_MODEL)
        model = model_file(values["model"], Path(path).parent)
        found = ModelFile.open(model, catalogue(effects)).at(None)
        return replace(cls.of(values, found.model.require_axes(model)), recognised=found.remarks)

    @classmethod
    def of(cls, values: dict, model: ErrorModel) -> "DriveSettings":
        """Convert a complete configuration."""
        arm, offset, scale = values["lever_arm"], values["time_offset"], values["scale_factor"]
        fix, quality, start, wheels = (values[name] for name in ("receiver", "quality", "start", "wheels"))
        assumptions = DriveAssumptions(
            lever_m=(arm["x_m"], arm["y_m"], arm["z_m"]),
            lever_std=arm["std_m"],
            time_offset_s=offset["offset_s"],
            time_offset_std=offset["std_s"],
            scale_std=(scale["gyro_std"], scale["accel_std"]),
            scale_s=np.inf if scale["correlation_s"] is None else scale["correlation_s"],
            position_std=(fix["horizontal_m"], fix["horizontal_m"], fix["vertical_m"]),
            slow_position_std=(fix["slow_horizontal_m"], fix["slow_horizontal_m"], fix["slow_vertical_m"]),
            slow_position_s=fix["slow_s"],
            velocity_std=(fix["horizontal_m_per_s"], fix["horizontal_m_per_s"], fix["vertical_m_per_s"]),
            velocity_delay_s=fix["velocity_delay_s"],
            std_factors=tuple(fix[name] for name in FACTOR_KEYS),
            epoch_s=values["epoch_s"],
            nonholonomic_std=wheels["std_m_per_s"],
            nonholonomic_s=wheels["correlation_s"],
            axle_m=(wheels["x_m"], wheels["y_m"], wheels["z_m"]),
        )
        control = QualityControl(
            component=quality["component_sigma"],
            separation_s=quality["separation_s"],
            **{name: quality[name] for name in CONTROLS},
        )
        course, heading, tilt = (np.radians(start[f"{name}_std_deg"]) for name in ("course", "heading", "tilt"))
        alignment = AlignmentSettings(
            speed=start["speed_m_per_s"], rest_s=start["rest_s"], course_std=course, heading_std=heading, tilt_std=tilt
        )
        mounting = tuple(np.radians([values["mounting"][f"{name}_deg"] for name in ATTITUDE]))
        return cls(model, mounting, assumptions, control, alignment, offset["rate_ppm"] * clock_rate.PPM)

    @classmethod
    def in_use(cls, inputs: DriveInputs, mounting: tuple[float, float, float]) -> "DriveSettings":
        """Return the settings of the inputs of a filter, by which the same follows from the logs as they were given.

        The noise of a receiver that states none is stated in its place.
        """
        known, fixes = inputs.assumptions, inputs.fixes
        across, down, fast, climbing = known.std_factors
        if PLACE_STD[0] not in fixes:
            stated = tuple(float(one) for one in np.array(known.position_std) * (across, across, down))
            known, across, down = replace(known, position_std=stated), 1.0, 1.0
        if VELOCITY_STD[0] not in fixes:
            stated = tuple(float(one) for one in np.array(known.velocity_std) * (fast, fast, climbing))
            known, fast, climbing = replace(known, velocity_std=stated), 1.0, 1.0
        known = replace(known, std_factors=(across, down, fast, climbing))
        return cls(inputs.model, mounting, known, inputs.quality, inputs.alignment, known.clock_rate)

    def mapping(self) -> dict:
        """Return the configuration without its model, in the keys of the schema; what is at its default is left out."""
        own, control, start = self.assumptions, self.quality, self.alignment
        values = {
            "mounting": dict(zip((f"{name}_deg" for name in ATTITUDE), map(_degrees, self.mounting), strict=True)),
            "lever_arm": {**_by_axis(own.lever_m), "std_m": own.lever_std},
            "time_offset": {
                "offset_s": own.time_offset_s, "rate_ppm": self.clock_rate / clock_rate.PPM,
                "std_s": own.time_offset_std,
            },
            "scale_factor": {
                "gyro_std": own.scale_std[0], "accel_std": own.scale_std[1],
                "correlation_s": None if np.isinf(own.scale_s) else own.scale_s,
            },
            "receiver": {
                "horizontal_m": own.position_std[0], "vertical_m": own.position_std[2],
                "horizontal_m_per_s": own.velocity_std[0], "vertical_m_per_s": own.velocity_std[2],
                "slow_horizontal_m": own.slow_position_std[0], "slow_vertical_m": own.slow_position_std[2],
                "slow_s": own.slow_position_s, "velocity_delay_s": own.velocity_delay_s,
                **dict(zip(FACTOR_KEYS, own.std_factors, strict=True)),
            },
            "wheels": {
                "std_m_per_s": own.nonholonomic_std, "correlation_s": own.nonholonomic_s, **_by_axis(own.axle_m),
            },
            "quality": {
                "component_sigma": control.component, "separation_s": control.separation_s,
                **{name: getattr(control, name) for name in CONTROLS},
            },
            "start": {
                "speed_m_per_s": start.speed, "rest_s": start.rest_s, "course_std_deg": _degrees(start.course_std),
                "heading_std_deg": _degrees(start.heading_std), "tilt_std_deg": _degrees(start.tilt_std),
            },
        }  # fmt: skip
        default = configuration.configure({}, SCHEMA)
        changed = {
            group: {key: one for key, one in own.items() if one != default[group][key]} for group, own in values.items()
        }
        epoch = {} if own.epoch_s == default["epoch_s"] else {"epoch_s": own.epoch_s}
        return {group: own for group, own in changed.items() if own} | epoch

    def text(self, model: str) -> str:
        """Return the configuration as YAML, with the name of the file of its model."""
        return yaml.safe_dump({"model": model} | self.mapping(), sort_keys=False)


def _by_axis(arm: tuple[float, float, float]) -> dict[str, float]:
    return dict(zip(("x_m", "y_m", "z_m"), arm, strict=True))


def _degrees(angle: float) -> float:
    """Return an angle in degrees with the digits that survive the conversion."""
    return float(f"{np.degrees(angle):.15g}")
