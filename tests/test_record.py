import numpy as np
import pandas as pd
import pytest
from scipy.signal import butter, lfilter
from scipy.stats import binom

from imugap import log
from imugap.discovery.record import prepare
from imugap.effects import (
    Bias,
    Resolution,
    SampleLoss,
    Saturation,
    StuckSamples,
    TimestampJitter,
    WhiteNoise,
)
from imugap.log import LogError
from imugap.model import AxisModel, ErrorModel
from imugap.stream import stream

SD = 0.1
NOISE = WhiteNoise(SD * 0.1)
"""Deviation 0.1 at 100 Hz."""


def still(count, axes=("gyro_x",), interval=0.01):
    return log.from_samples({axis: np.zeros(count) for axis in axes}, interval)


def device(*effects, clock=(), axes=("gyro_x",)):
    """Noise and effects, the same on all axes."""
    return ErrorModel({axis: AxisModel((NOISE, *effects)) for axis in axes} | {"time": AxisModel(clock)})


def prepared(*effects, clock=(), axes=("gyro_x",), count=5000, seed=1):
    return prepare(device(*effects, clock=clock, axes=axes).simulate(still(count, axes), seed, "record"))


def names(record):
    """The effects that are named, with their axes."""
    return {(axis, effect.name) for found in record.findings for axis, effect in found.effects.items()}


def parameters(record, name):
    """The parameters of the one finding of a name."""
    (finding,) = [found for found in record.findings if next(iter(found.effects.values())).name == name]
    return finding.parameters


COLOURS = ("white", "walk", "flicker", "filtered", "swing", "tailed", "uniform")


def coloured(kind, count, rng):
    """Noise of unit deviation or so without any flaw."""
    white = rng.standard_normal(count)
    if kind == "walk":
        return white + rng.choice([0.01, 0.05, 0.2]) * np.cumsum(rng.standard_normal(count))
    if kind == "flicker":
        shape = np.sqrt(np.r_[1.0, np.fft.rfftfreq(2 * count)[1:]])
        slow = np.fft.irfft(np.fft.rfft(rng.standard_normal(2 * count)) / shape)[:count]
        return white + slow / slow.std()
    if kind == "filtered":
        low = lfilter(*butter(2, rng.choice([0.1, 0.3, 0.6])), white)
        return low / low.std()
    if kind == "swing":
        return 0.3 * white + 3 * np.sin(2 * np.pi * rng.uniform(0.001, 0.2) * np.arange(count))
    return {"tailed": rng.standard_t(5, count), "uniform": rng.uniform(-1, 1, count)}.get(kind, white)


def written(values, rng):
    """The values as a device or a file rounds them, and the step if it is none of the file."""
    form = rng.choice(["as they are", "lattice", "decimals", "digits", "degrees", "single"])
    if form == "lattice":
        step = rng.uniform(0.3, 3.0) * values.std()
        return step * np.rint(values / step), step
    if form == "degrees":
        step = np.radians(rng.choice([1e-3, 1 / 16.4, 1 / 131, 0.05]))
        return step * np.rint(values / step), step
    if form == "decimals":
        digits = int(rng.integers(3, 10))
        return np.round(values, digits), 10.0**-digits
    if form == "digits":
        digits = int(rng.integers(4, 10))
        step = 10.0 ** (np.floor(np.log10(np.abs(values).max())) - digits + 1)
        return np.array([float(f"{value:.{digits - 1}e}") for value in values]), step
    return (values.astype(np.float32).astype(float) if form == "single" else values), 0.0


def ticking(count, rng):
    """Stamps of an even clock as a device or a file rounds them."""
    interval = 1 / rng.choice([50, 100, 104, 119, 200, 249.756, 400, 800, 952])
    time = interval * np.arange(count)
    forms = {
        "exact": lambda: time,
        "summed": lambda: np.cumsum(np.full(count, interval)),
        "decimals": lambda: np.round(time, int(rng.integers(3, 10))),
        "ticks": lambda: np.round(np.rint(time * 32768) / 32768, int(rng.choice([6, 9]))),
        "single": lambda: time.astype(np.float32).astype(float),
        "epoch": lambda: 1.7e9 + time,
    }
    return forms[rng.choice(list(forms))]()


def healthy(*labels):
    """A log with nothing hidden, and the steps of its axes."""
    rng = stream(9, "healthy", *labels)
    count, columns, steps = int(rng.choice([2000, 5000])), {}, {}
    for axis in rng.choice(log.AXES, 2, replace=False):
        values = coloured(rng.choice(COLOURS), count, rng) * 10 ** rng.uniform(-3, 0) + rng.choice([0.0, 0.3, -9.81])
        columns[axis], steps[axis] = written(values, rng)
    table = pd.DataFrame(columns, index=pd.Index(ticking(count, rng), name="time"))
    return table[[axis for axis in log.AXES if axis in columns]], steps


def check_silence(cases):
    """No name but that of a lattice that is there, no gap of the stamps."""
    named = 0
    for case in cases:
        table, steps = healthy(case)
        record = prepare(table)
        for axis, name in names(record):
            assert name == "resolution", (case, axis, name)
            assert parameters_of(record, axis).step == pytest.approx(steps[axis], rel=1e-3), (case, axis)
            named += 1
        assert not [gap for gap in record.gaps if gap.view == "stamps"], case
    return named


def parameters_of(record, axis):
    return next(found.effects[axis] for found in record.findings if axis in found.effects)


def test_nothing_is_named_where_nothing_is_hidden():
    assert check_silence(range(120)) > 20  # lattices are there to be named


@pytest.mark.slow
def test_nothing_is_named_in_a_thousand_logs_where_nothing_is_hidden():
    assert check_silence(range(120, 1120)) > 200


def covered(truth, name, cases, **device_of):
    """In how many of so many logs the interval of each parameter holds the truth, and their mean relative widths."""
    hits, widths = dict.fromkeys(truth, 0), dict.fromkeys(truth, 0.0)
    for case in range(cases):
        found = parameters(prepared(**device_of, seed=100 + case), name)
        for key, value in truth.items():
            hits[key] += found[key].low <= value <= found[key].high
            widths[key] += (found[key].high - found[key].low) / value / cases
    return hits, widths


CASES = 100
LEAST = int(binom.ppf(1e-4, CASES, 0.95))


@pytest.mark.parametrize(
    ("effect", "arguments", "width"),
    [
        (StuckSamples(0.02, 3.0), {}, 0.5),
        (SampleLoss(0.02, 3.0), {"clock": True}, 0.5),
        (TimestampJitter(1e-3), {"clock": True}, 0.05),
    ],
    ids=["stuck", "loss", "jitter"],
)
def test_intervals_hold_the_truth_and_are_no_wider_than_they_must(effect, arguments, width):
    device_of = {"clock": (effect,)} if arguments else {}
    hits, widths = np.zeros(2), np.zeros(2)
    truth = effect.parameters()
    for case in range(CASES):
        effects = () if arguments else (effect,)
        found = parameters(prepared(*effects, seed=100 + case, **device_of), effect.name)
        hits[: len(truth)] += [found[key].low <= value <= found[key].high for key, value in truth.items()]
        widths[: len(truth)] += [(found[key].high - found[key].low) / value / CASES for key, value in truth.items()]
    assert np.all(hits[: len(truth)] >= LEAST)
    assert np.all(widths[: len(truth)] < width)
