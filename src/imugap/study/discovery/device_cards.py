"""Device models for the library: what discovery found on the log of a device, with all that a user has to know of it.

What happened once in the log, such as a knock, is no property of the device: it is not in the model, and the card says
so.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import isfinite

import pandas as pd

from imugap.discovery.finding import Discrepancy
from imugap.discovery.verdict import describe_locations
from imugap.effects.effect import AxisModel
from imugap.interchange.devices.card import SCHEMA
from imugap.io.catalogue.datasets import DataSet
from imugap.log import ACCEL, AXES
from imugap.model import ErrorModel

DIGITS = 6
"""Significant digits of a number: the last ones differ from processor to processor."""
LONGEST_SHARE = 4
"""Duration of a log over the longest averaging time at which it shows a process."""
AT_REST = (
    "scale factor, misalignment, g-sensitivity, saturation, temperature and what vibration adds: the device was at rest"
)
ONE_RUN = "how the biases differ from one start to the next, and from unit to unit: one run of one unit"
SEVERAL_RUNS = "how devices differ from unit to unit: all runs are of one"


@dataclass(frozen=True, eq=False)
class DeviceFound:
    """What is known of a device.

    Attributes
    ----------
    title, remarks
        Name, and what a user of the model has to know of the log.
    dataset, runs
        Data set that the log is of, and its runs.
    in_motion
        Whether the device moved.
    report
        What discovery found, ``report.json``.
    parameters
        Parameters of the final model with intervals, ``parameters.csv``.
    settings
        Settings of discovery, by name.
    """

    title: str
    remarks: tuple[str, ...]
    dataset: DataSet
    runs: tuple[int, ...]
    in_motion: bool
    report: Mapping
    parameters: pd.DataFrame
    settings: Mapping[str, object]

    def card(self) -> dict:
        """Return the device model with its card as plain data."""
        final = ErrorModel.from_mapping(self.report["final_model"])
        lasting = {axis: AxisModel(tuple(one for one in model if not one.once)) for axis, model in final.axes.items()}
        model = ErrorModel({axis: one for axis, one in lasting.items() if len(tuple(one))})
        return _rounded({
            "schema": SCHEMA,
            "title": self.title,
            "data": self._data(),
            "made_by": {"command": "imugap discover", **self.settings},
            "remarks": list(self.remarks),
            "model": model.to_mapping(),
            "parameters": self._parameters(model),
            "not_told_apart": [
                {"axes": one["axes"], "effect": one["name"], "from": [rival["name"] for rival in one["alternatives"]]}
                for one in self.report["effects"] if one["alternatives"]
            ],
            "once": self._once(final),
            "not_known": list(dict.fromkeys(self._not_known(model))),
            "unexplained": self._unexplained(),
            "distances": {
                name: self.report[key]
                for key, name in (("distance", "distribution"), ("navigation_distance", "navigation"))
                if self.report[key]
            },
        })  # fmt: skip

    def _data(self) -> dict:
        own = self.dataset
        files = {own.file(run).name: own.file(run).sha256 for run in self.runs}
        return {
            "dataset": own.name, "title": own.title, "licence": own.licence, "source": own.source,
            "frame": own.frame, "files": [{"name": name, "sha256": digest} for name, digest in files.items()],
            "runs": list(self.runs), "in_motion": self.in_motion,
            "logs": [{key: one[key] for key in ("rate_hz", "begin_s", "duration_s")} for one in self.report["log"]],
            "remarks": own.remarks,
        }  # fmt: skip

    def _parameters(self, model: ErrorModel) -> list[dict]:
        """Return the parameters of the effects that the model has."""
        rows = []
        for row in self.parameters.to_dict("records"):
            effects = [one for one in model.axes.get(row["axis"], ()) if one.name == row["effect"]]
            if not any(getattr(one, row["parameter"]) == row["value"] for one in effects):
                continue
            ends = {key: row[key] if isfinite(row[key]) else None for key in ("low", "high")}
            cells = {key: row[key] for key in ("axis", "effect", "parameter", "value")} | ends
            rows.append(cells | {"unit": row["unit"]})
        return rows

    def _once(self, final: ErrorModel) -> list[dict]:
        return [
            {"axis": axis, "effect": one.name} | one.parameters()
            for axis, model in final.axes.items() for one in model if one.once
        ]  # fmt: skip

    def _not_known(self, model: ErrorModel) -> Iterable[str]:
        first = self.report["log"][0]
        longest = first["duration_s"] / LONGEST_SHARE
        yield f"processes slower than some {longest:.3g} s: the log lasts {first['duration_s']:.4g} s"
        if not self.in_motion:
            yield AT_REST
            if set(ACCEL) <= set(self.report["final_model"]):
                yield "the biases of the accelerometers: at rest they cannot be distinguished from gravity and tilt"
        yield ONE_RUN if len(self.report["log"]) == 1 else SEVERAL_RUNS
        lacking = [axis for axis in AXES if axis not in self.report["final_model"]]
        if lacking:
            yield f"{', '.join(lacking)}: not in the log, or without noise there"
        for axis, effects in model.axes.items():
            for one in effects:
                if one.of_time or one.tonal:
                    yield f"{axis}: how {one.name}, a function of the time, goes on beyond the log"
        for one in self.report["withheld"]:
            yield f"{one['axis']}: something like {one['name']}, but {one['reason']}"

    def _unexplained(self) -> str:
        places = [Discrepancy(**one) for one in self.report["unexplained"]]
        return describe_locations(places) if places else "nothing"


def _rounded(value: object) -> object:
    """Return plain data with numbers of :data:`DIGITS` digits."""
    match value:
        case dict():
            return {key: _rounded(one) for key, one in value.items()}
        case list():
            return [_rounded(one) for one in value]
        case bool() | int() | str() | None:
            return value
    return float(f"{value:.{DIGITS}g}")
