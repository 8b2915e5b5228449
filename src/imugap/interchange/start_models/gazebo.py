"""SDF of Gazebo: the noise of its ``<imu>``."""

from collections.abc import Iterator
from math import sqrt
from xml.etree.ElementTree import Element

from imugap.effects import Bias, GaussMarkov, Resolution, TurnOnBias, WhiteNoise
from imugap.effects.effect import Effect
from imugap.interchange.conventions import GAZEBO
from imugap.interchange.start_models.document import Document
from imugap.interchange.start_models.reading import (
    Key,
    Reader,
    Reading,
    correlation_time,
    driving_density,
    model_of,
    number,
    per_sample,
    require_rate,
    std,
)
from imugap.log import TRIADS

ELEMENTS = {"gyro": "angular_velocity", "accel": "linear_acceleration"}
TYPES = ("none", "gaussian", "gaussian_quantized")
FINEST = 1e-6
"""Precision below which Gazebo does not round."""
NAMES = (
    "mean", "stddev", "bias_mean", "bias_stddev", "dynamic_bias_stddev", "dynamic_bias_correlation_time", "precision",
)  # fmt: skip


def _imus(document: Document) -> list[tuple[Element, Element | None]]:
    """Return each element ``imu`` with its sensor, if it is in one."""
    if not isinstance(document, Element):
        return []
    if document.tag == "imu":
        return [(document, None)]
    within = [(imu, sensor) for sensor in document.iter("sensor") for imu in sensor.findall("imu")]
    return within or [(imu, None) for imu in document.iter("imu")]


def _read(document: Document, rate: float | None) -> Reading:
    imus, remarks = _imus(document), []
    first, sensor = imus[0]
    if any(_noise(first) != _noise(other) for other, _ in imus[1:]):
        raise ValueError(f"imu: expected one, or several of the same noise; found {len(imus)} that differ")
    stated = None if sensor is None else sensor.findtext("update_rate")
    if stated is not None and number({"update_rate": _number("update_rate", stated)}, "update_rate") > 0:
        own = float(stated)
        if rate is not None and abs(own / rate - 1) > 0.01:
            remarks.append(f"stddev is taken at the update_rate, {own:g} Hz, not at {rate:g} Hz")
        rate = own
    values, axes = _noise(first), {}
    for kind, element in ELEMENTS.items():
        for axis in TRIADS[kind]:
            axes[axis] = tuple(_effects(values.get((element, axis[-1]), {}), rate))
    if any(one.get("bias_mean") for one in values.values()):
        remarks.append("Gazebo draws the sign of bias_mean at the start")
    if any(0 < one.get("precision", 0.0) < FINEST for one in values.values()):
        remarks.append(f"not in the model: precision below {FINEST:g}, which Gazebo does not apply")
    if any(one.get("dynamic_bias_stddev") for one in values.values()):
        remarks.append("the dynamic bias of Gazebo starts at the bias, and forgets it within its correlation time")
    return Reading(model_of(axes), tuple(remarks), {kind: _keys(element, rate) for kind, element in ELEMENTS.items()})


def _noise(imu: Element) -> dict[tuple[str, str], dict[str, float]]:
    """Return the numbers of each axis with noise."""
    found = {}
    for element in ELEMENTS.values():
        for axis in "xyz":
            noise = imu.find(f"{element}/{axis}/noise")
            kind = None if noise is None else noise.get("type") or noise.findtext("type") or "gaussian"
            if kind is not None and kind not in TYPES:
                raise ValueError(f"{element}: {axis}: expected noise of type {', '.join(TYPES)}; found {kind!r:.40}")
            if kind in TYPES[1:]:
                texts = {name: noise.findtext(name) for name in NAMES}
                found[element, axis] = {name: _number(name, text) for name, text in texts.items() if text is not None}
    return found


def _number(name: str, text: str) -> float:
    try:
        return number({name: float(text)}, name)
    except ValueError:
        raise ValueError(f"{name}: expected a finite number; found {text!r:.40}") from None


def _effects(values: dict[str, float], rate: float | None) -> Iterator[Effect]:
    """Yield the effects of one axis."""
    of = dict.fromkeys(NAMES, 0.0) | values
    if of["stddev"]:
        yield WhiteNoise(of["stddev"] / sqrt(require_rate(rate, "stddev")))
    time = of["dynamic_bias_correlation_time"]
    std = of["dynamic_bias_stddev"] * sqrt(time / 2) if time > 0 else 0.0
    if std:
        yield GaussMarkov(std, time)
    yield Bias(of["mean"] + of["bias_mean"])
    yield TurnOnBias(sqrt(max(of["bias_stddev"] ** 2 - std**2, 0.0)))
    if of["precision"] >= FINEST:
        yield Resolution(of["precision"])


def _keys(element: str, rate: float | None) -> tuple[Key, ...]:
    """Return the keys of an element, in the words of the file."""
    white = () if rate is None else (("stddev", WhiteNoise, per_sample(rate)),)
    every = (
        *white,
        ("dynamic_bias_stddev", GaussMarkov, driving_density),
        ("dynamic_bias_correlation_time", GaussMarkov, correlation_time),
        ("mean", Bias, lambda bias: bias.value),
        ("bias_stddev", TurnOnBias, std),
    )
    known = (Key.of(GAZEBO, f"{element} {name}", kind, si, f"<{name}> of <{element}>") for name, kind, si in every)
    unit = GAZEBO.unit(f"{element} stddev")
    return (*known, Key(f"<precision> of <{element}>", unit, Resolution, lambda rounded: rounded.step))


READER = Reader("Gazebo", GAZEBO, lambda document: bool(_imus(document)), _read)
