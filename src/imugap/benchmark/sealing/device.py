"""Base devices: six axes with biases, noise and gravity, a rest or a motion, and a temperature."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from imugap.benchmark.sealing.hidden_effect import between, sign
from imugap.benchmark.sealing.motion import GRAVITY, MOTIONS, Motion
from imugap.benchmark.sealing.noise import Noise
from imugap.log import ACCEL, AXES, GYRO

CROSSING = 2 * np.log(2) / np.pi
"""Allan variance of flicker noise over B^2."""


@dataclass(frozen=True, eq=False)
class Device:
    """A base device: bias and noise by axis, the direction of gravity at rest, and the motion if it moves."""

    bias: Mapping[str, float]
    noise: Mapping[str, Noise]
    down: Mapping[str, float]
    motion: Motion | None

    @classmethod
    def draw(cls, base: str, motion: str, interval: float, duration: float, recipe: Mapping, rng) -> "Device":
        """Draw a device of the kind ``base`` that moves by ``motion`` (``rest`` or a name of :data:`MOTIONS`)."""
        noise, bias = {}, {}
        for triad, name in ((GYRO, "gyro"), (ACCEL, "accel")):
            level = between(rng, recipe[name]["density"])
            crossing = duration * between(rng, recipe["crossing_share"])
            line = between(rng, recipe["line"]["frequency_share"]) / interval
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
        still = {axis: np.full(len(time), value) for axis, value in self.down.items()}
        return pd.DataFrame(still, index=pd.Index(time, name="time"))

    def model(self) -> dict[str, list[dict[str, dict[str, float]]]] | None:
        """Return the start model as plain data, or None where it is bias and white noise.

        At rest the constant of an axis is its bias and its share of gravity.
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
    """Draw a temperature [degC] at ``time`` [s]: the room, self-heating after power-on, a slow swing."""
    ambient, heating, swing = (rng.uniform(*recipe[key]) for key in ("ambient_degC", "heating_degC", "swing_degC"))
    constant, period = (time[-1] * rng.uniform(*recipe[key]) for key in ("constant_share", "period_share"))
    slow = np.sin(2 * np.pi * (time / period + rng.uniform()))
    return ambient - heating * np.expm1(-time / constant) + swing * slow


def _noise(base: str, density: float, interval: float, crossing: float, line: float, size: float) -> Noise:
    """Return the noise of an axis: its slow part exceeds the white one beyond the averaging time ``crossing`` [s]."""
    if base == "flicker":
        return Noise(density, density_b=density / np.sqrt(crossing * CROSSING))
    if base == "walk":
        return Noise(density, density_k=np.sqrt(3) * density / crossing)
    if base == "quantization":
        return Noise(q=density * np.sqrt(interval / 2))
    if base == "line":
        return Noise(density, amplitude=density * np.sqrt(size), frequency=line)
    return Noise(density)


def _coloured(noise: Noise) -> bool:
    return noise != Noise(noise.density)
