"""Base devices: six axes with biases, noise and gravity, a rest or a motion, and a temperature."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np
import pandas as pd

from imu_benchmark.log import ACCEL, AXES, GYRO
from imu_benchmark.sealing.hidden_effect import log_uniform, sign
from imu_benchmark.sealing.motion import GRAVITY, MOTIONS, AnalyticMotion
from imu_benchmark.sealing.noise import BaseNoise

CROSSING = 2 * np.log(2) / np.pi
"""Allan variance of flicker noise over B^2."""


@dataclass(frozen=True, eq=False)
class BaseDevice:
    """A base device: bias and noise of each axis, gravity on each axis at rest, and the motion, if any."""

    bias: Mapping[str, float]
    noise: Mapping[str, BaseNoise]
    down: Mapping[str, float]
    motion: AnalyticMotion | None

    @classmethod
    def draw(cls, base: str, motion: str, interval: float, duration: float, recipe: Mapping, rng) -> Self:
        """Draw a device of the kind ``base`` with the motion ``motion`` (``rest`` or a key of :data:`MOTIONS`)."""
        noise, bias = {}, {}
        for triad, name in ((GYRO, "gyro"), (ACCEL, "accel")):
            level = log_uniform(rng, recipe[name]["density"])
            crossing = duration * log_uniform(rng, recipe["crossing_share"])
            line = log_uniform(rng, recipe["line"]["frequency_share"]) / interval
            for axis in triad:
                density = level * rng.uniform(*recipe["unevenness"])
                noise[axis] = _noise(base, density, interval, crossing, line, recipe["line"]["size"] / duration)
                bias[axis] = float(rng.normal(scale=recipe[name]["bias_std"]))
        upright = rng.choice(ACCEL)
        side = sign(rng)
        down = {axis: side * GRAVITY * (axis == upright) for axis in AXES}
        return cls(bias, noise, down, MOTIONS[motion](rng) if motion != "rest" else None)

    def ideal(self, time: np.ndarray) -> pd.DataFrame:
        """Return the error-free log of six axes at the instants ``time`` [s]."""
        if self.motion is not None:
            return self.motion.ideal(time)
        constant = {axis: np.full(len(time), value) for axis, value in self.down.items()}
        return pd.DataFrame(constant, index=pd.Index(time, name="time"))

    def model(self) -> dict[str, list[dict[str, dict[str, float]]]] | None:
        """Return the start model as plain data, or None where it is bias and white noise.

        At rest the constant of an axis is the sum of its bias and of gravity.
        """
        return {axis: self._axis(axis) for axis in AXES} if any(map(_coloured, self.noise.values())) else None

    def _axis(self, axis: str) -> list[dict[str, dict[str, float]]]:
        noise = self.noise[axis]
        constant = self.bias[axis] + (self.down[axis] if self.motion is None else 0.0)
        named = {
            "white_noise": {"density": noise.density},
            "bias_instability": {"density_b": noise.density_b},
            "random_walk": {"density_k": noise.density_k},
            "quantization": {"q": noise.q},
            "sinusoid": {"amplitude": noise.amplitude, "frequency": noise.frequency},
        }
        present = [{name: values} for name, values in named.items() if all(values.values())]
        return [
            {name: {key: float(value) for key, value in values.items()}}
            for item in ({"bias": {"value": constant}}, *present)
            for name, values in item.items()
        ]


def temperature(time: np.ndarray, recipe: Mapping, rng: np.random.Generator) -> np.ndarray:
    """Draw a temperature [degC] at ``time`` [s]: ambient, self-heating after power-on, and a slow oscillation."""
    ambient, heating, swing = (rng.uniform(*recipe[key]) for key in ("ambient_degC", "heating_degC", "swing_degC"))
    constant, period = (time[-1] * rng.uniform(*recipe[key]) for key in ("constant_share", "period_share"))
    slow = np.sin(2 * np.pi * (time / period + rng.uniform()))
    return ambient - heating * np.expm1(-time / constant) + swing * slow


def _noise(base: str, density: float, interval: float, crossing: float, line: float, size: float) -> BaseNoise:
    """Return the noise of an axis; its slow part exceeds the white part beyond the averaging time ``crossing`` [s]."""
    if base == "flicker":
        return BaseNoise(density, density_b=density / np.sqrt(crossing * CROSSING))
    if base == "walk":
        return BaseNoise(density, density_k=np.sqrt(3) * density / crossing)
    if base == "quantization":
        return BaseNoise(q=density * np.sqrt(interval / 2))
    if base == "line":
        return BaseNoise(density, amplitude=density * np.sqrt(size), frequency=line)
    return BaseNoise(density)


def _coloured(noise: BaseNoise) -> bool:
    return noise != BaseNoise(noise.density)
