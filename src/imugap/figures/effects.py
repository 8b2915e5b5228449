"""Picture of one effect: what it makes of the signal of one axis in a simple motion."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from imugap import log
from imugap.effects import WhiteNoise
from imugap.effects.effect import AllanEffect, AxisModel, Effect, Stage
from imugap.figures.style import panels_of
from imugap.model import ErrorModel

RATE_HZ, COUNT = 50.0, 3000
"""Sampling rate and number of samples of the log."""
TEMPERATURES = (20.0, 40.0)
"""Temperature at the begin and at the end [degC]."""
DENSITY = 0.05
"""Density of white noise that is added where an effect acts on other errors."""
SEED = 1


def picture(effect: Effect, axis: str) -> Figure:
    """Draw the signal with an effect and its error, or its Allan deviation; of the clock the steps of the stamps.

    ``axis`` is one on which the effect has a place, or the pseudo-axis of the clock.
    """
    ideal = _motion()
    besides = (WhiteNoise(DENSITY),) if effect.stage in (Stage.MODULATION, Stage.SEQUENCE) else ()
    measured = ErrorModel({axis: AxisModel((*besides, effect))}).simulate(ideal, SEED, "picture")
    figure, ((left, right),) = panels_of(1, 2, 2.4)
    if axis == log.TIME:
        left.plot(measured.index, measured[log.AXES[0]], ".", markersize=1)
        right.plot(measured.index[1:], np.diff(measured.index), ".", markersize=2)
        _title(left, "Samples", log.AXES[0])
        _title(right, "Steps of the stamps", "step [s]")
        return figure
    error = measured[axis] - ideal[axis]
    left.plot(ideal.index, ideal[axis], color="0.6", label="error-free")
    left.plot(measured.index, measured[axis], label=effect.name)
    left.legend()
    _title(left, "Signal", axis)
    if isinstance(effect, AllanEffect):
        tau = np.geomspace(1 / RATE_HZ, COUNT / RATE_HZ, 100)
        right.loglog(tau, np.sqrt(effect.allan_variance(tau)))
        right.set(title="Allan deviation", xlabel="averaging time [s]", ylabel="deviation")
    else:
        right.plot(error.index, error)
        _title(right, "Error", "signal less error-free signal")
    return figure


def _title(panel, title: str, label: str) -> None:
    panel.set(title=title, xlabel="time [s]", ylabel=label)


def _motion() -> pd.DataFrame:
    """Return an error-free log: each axis swings at a frequency of its own, z carries gravity, the device warms up."""
    time = np.arange(COUNT) / RATE_HZ
    samples = {axis: 2 * np.sin(2 * np.pi * (0.1 + 0.03 * k) * time) for k, axis in enumerate(log.AXES)}
    samples["accel_z"] = samples["accel_z"] - 9.80665
    return log.from_samples(samples | {log.TEMPERATURE: np.linspace(*TEMPERATURES, COUNT)}, 1 / RATE_HZ)
