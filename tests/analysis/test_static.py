"""A run that is simulated in parts is the run that is simulated at once."""

import numpy as np
import pandas as pd
import pytest
from tests.effects.simulated import EXAMPLES, allan_variances

from imugap import log
from imugap.analysis import static
from imugap.effects import (
    BandNoise,
    BiasInstability,
    ClockScale,
    GaussMarkov,
    Misalignment,
    OutputFilter,
    PowerLaw,
    SampleLoss,
    TimestampJitter,
    WhiteNoise,
)
from imugap.effects.effect import AxisModel, ClockEffect
from imugap.model import ErrorModel

OTHER_DRAWS = ("band_noise", "bias_instability", "power_law")
NO_PLACE = ("temperature",)
"""Effects that need a temperature, which a device at rest does not have."""


def model(effect):
    """A device of white noise on all axes, with an effect on one of them or on the clock."""
    effect = Misalignment(0.0, -0.02, 0.01) if effect.name == "misalignment" else effect
    axis = log.TIME if isinstance(effect, ClockEffect) else "accel_x" if effect.name == "lever_arm" else "gyro_x"
    axes = dict.fromkeys(log.AXES, AxisModel((WhiteNoise(0.1),)))
    return ErrorModel(axes | {axis: AxisModel((*axes.get(axis, ()), effect))})


def in_parts(device, seed=3, count=3000, most=700):
    return list(static.simulate_parts(device, count / 30, 30, seed=seed, whole=most, most=most))


@pytest.mark.parametrize("name", [name for name in EXAMPLES if name not in (*OTHER_DRAWS, *NO_PLACE)])
def test_parts_have_the_samples_of_the_whole_run(name):
    device = model(EXAMPLES[name])
    parts = in_parts(device)
    whole = static.simulate(device, 100, 30, seed=3)
    pd.testing.assert_frame_equal(pd.concat(parts), whole, rtol=1e-12, atol=1e-13)
    assert len(parts) == (1 if name == "stability_restoration" else 5)


def test_clock_effects_and_lost_samples_follow_one_another_in_parts():
    device = ErrorModel({
        "gyro_x": WhiteNoise(0.1) + GaussMarkov(0.2, 3.0) + OutputFilter(2.0, 2, 1) + SampleLoss(0.02, 30.0),
        log.TIME: AxisModel((SampleLoss(0.01, 900.0), TimestampJitter(0.2), ClockScale(1.001))),
    })  # fmt: skip
    whole = static.simulate(device, 100, 30, seed=5)
    assert 100 < len(whole) < 2900
    pd.testing.assert_frame_equal(pd.concat(in_parts(device, 5, most=100)), whole, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize(
    "effect",
    [
        BandNoise(0.4, 4.0, 6.0),
        BandNoise(0.4, 0.5, 0.8),
        BiasInstability(0.4),
        PowerLaw(0.4, 0.6),
        PowerLaw(0.4, 1.5),
        PowerLaw(0.4, 2.6),
    ],
)
def test_noise_from_other_draws_has_its_allan_variance_in_parts(effect):
    averaging, interval = np.array([1, 4, 16, 64, 256]), 1 / 30
    device = ErrorModel({"gyro_x": AxisModel((effect,))})
    drawn = [pd.concat(in_parts(device, seed))["gyro_x"].to_numpy() for seed in range(80)]
    found = allan_variances(drawn, averaging)
    expected = effect.sampled_allan_variance(averaging, interval)
    error = found.std(axis=0) / np.sqrt(len(found))
    assert np.all(np.abs(found.mean(axis=0) - expected) < 4 * error + 0.01 * expected)


def test_a_short_run_is_the_file_of_before(tmp_path):
    device = model(BiasInstability(0.4))
    whole = static.simulate(device, 20, 50, seed=1)
    for name in ("run.csv", "run.parquet"):
        log.write(whole, tmp_path / f"whole_{name}")
        assert log.write_parts(static.simulate_parts(device, 20, 50, seed=1), tmp_path / name) == 1000
        assert (tmp_path / name).read_bytes() == (tmp_path / f"whole_{name}").read_bytes()


def test_a_run_in_parts_is_one_file(tmp_path):
    parts = in_parts(model(GaussMarkov(0.2, 3.0)))
    log.write_parts(parts, tmp_path / "run.csv")
    pd.concat(parts).to_csv(tmp_path / "whole.csv")
    assert (tmp_path / "run.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()
    log.write_parts(parts, tmp_path / "run.parquet")
    pd.testing.assert_frame_equal(log.load(tmp_path / "run.parquet"), pd.concat(parts))
