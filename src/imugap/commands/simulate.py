"""Write the static log of a device with a given error model.

Stages: read the model; make the error-free log of a device at rest; simulate; write.
"""

import argparse
import os

import numpy as np
import pandas as pd

from imugap import log
from imugap.commands.arguments import add_effects, add_examples, add_gravity, add_seed, positive, rate
from imugap.commands.outputs import require_files
from imugap.commands.reading import MODEL_HELP, model_at, open_model
from imugap.model import ErrorModel


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_examples(parser, "imugap simulate model.yaml --duration 600 --rate 100 --out simulated.csv")
    parser.add_argument("model", help=MODEL_HELP)
    add_effects(parser)
    parser.add_argument("--duration", type=positive, required=True, help="length [s]")
    parser.add_argument("--rate", type=rate, required=True, help="sampling rate [Hz]")
    add_gravity(parser)
    add_seed(parser)
    parser.add_argument("--out", required=True, help="Parquet or CSV file")


def run(options: argparse.Namespace) -> None:
    """Simulate a device at rest and write its log to ``--out``."""
    require_files({"--out": options.out}, [options.model])
    log.require_format(options.out)
    model = _read(options.model, options.effects, options.rate)
    ideal = _at_rest(model, options.duration, options.rate, options.gravity)
    log.write(model.simulate(ideal, options.seed, "simulate"), options.out)


def _read(path: str, effects: str | None, rate: float) -> ErrorModel:
    model = model_at(open_model(path, effects), rate)
    if not model.sensors:
        raise ValueError(f"{path}: expected a model of at least one sensor axis; found none")
    return model


def _at_rest(model: ErrorModel, duration: float, rate: float, gravity: float) -> pd.DataFrame:
    """Return the error-free log of the axes of ``model``, z down; ValueError where it exceeds the memory."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    samples, most = (
        duration * rate,
        memory // (2 * 8 * (len(model.sensors) + 1)),
    )  # its columns, and as many random ones
    if samples > most:
        raise ValueError(f"simulate: expected a duration and rate of at most {most:.3g} samples; found {samples:.3g}")
    values = {axis: -gravity if axis == "accel_z" else 0.0 for axis in log.AXES if axis in model.axes}
    return log.from_samples({axis: np.full(round(samples), value) for axis, value in values.items()}, 1 / rate)
