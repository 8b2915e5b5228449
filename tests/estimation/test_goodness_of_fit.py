import numpy as np
import pytest
from scipy.stats import binomtest

from imugap.effects import Conditions, GaussMarkov, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation import goodness_of_fit, maximum_likelihood

INTERVAL, COUNT = 0.01, 20_000
MODEL = WhiteNoise(1e-3) + GaussMarkov(5e-3, 1.0)


def simulate(*labels, of=MODEL):
    return of.simulate(np.zeros(COUNT), Conditions(np.arange(COUNT) * INTERVAL, INTERVAL), 41, *labels)


@pytest.mark.slow
def test_a_right_model_fits_as_often_as_the_level_says():
    """With the true parameters; the family-wise bound errs on the safe side by a little."""
    runs = 120
    fits = sum(goodness_of_fit.of(MODEL, simulate("right", run), INTERVAL, fitted=False).fits for run in range(runs))
    low, high = binomtest(fits, runs).proportion_ci(0.999)
    assert low < 0.95 < high or fits / runs > 0.95


def test_a_line_is_seen_in_its_octave():
    time = np.arange(COUNT) * INTERVAL
    sequence = simulate("line") + 5e-3 * np.sin(2 * np.pi * 20 * time)
    found = maximum_likelihood.fit(sequence, INTERVAL, (WhiteNoise, GaussMarkov)).model
    judged = goodness_of_fit.of(found, sequence, INTERVAL)
    assert not judged.fits
    assert judged.p_value < 1e-6
    octave = judged.table.loc[2]  # 12.5 to 25 Hz
    assert octave["low_hz"] < 20 < octave["high_hz"]
    assert octave["ratio"] > 1
    assert "12.5-25 Hz, averaging time 0.02 s: " in judged.verdict
    assert judged.off[0] == (0.02, 0.02)


@pytest.mark.parametrize("scale", [1e-6, 1e3])
def test_units_do_not_matter(scale):
    sequence = simulate("units")
    scaled = AxisModel((WhiteNoise(scale * 1e-3), GaussMarkov(scale * 5e-3, 1.0)))
    one, other = goodness_of_fit.of(MODEL, sequence, INTERVAL), goodness_of_fit.of(scaled, scale * sequence, INTERVAL)
    np.testing.assert_allclose(other.table["p"], one.table["p"], rtol=1e-5)
    assert other.verdict == one.verdict
