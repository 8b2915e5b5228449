import numpy as np
import pytest
from scipy.integrate import quad

from imugap.effects import BiasInstability, GaussMarkov, Quantization, RandomWalk, WhiteNoise
from imugap.estimation.variances import modwt_transfer, wavelet_variance
from imugap.numerics.spectra.daubechies import WIDTHS, depth, squared_gain

INTERVAL = 0.01
PROCESSES = (WhiteNoise(0.1), RandomWalk(0.2), GaussMarkov(0.5, 0.3), BiasInstability(0.3))


def per_sample(process):
    """The sampled spectrum over cycles per sample: its integral over one cycle is the variance."""
    return lambda cycles: process.sampled_psd(cycles / INTERVAL, INTERVAL) / INTERVAL


@pytest.mark.parametrize("process", [*PROCESSES, Quantization(1e-3)], ids=lambda p: p.name)
def test_implied_haar_variance_is_the_spectral_one(process):
    found = modwt_transfer.passed(per_sample(process), 12)
    np.testing.assert_allclose(found, wavelet_variance.implied(process, INTERVAL, 12), rtol=1e-11)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("process", PROCESSES, ids=lambda p: p.name)
def test_overlap_of_two_levels_is_the_integral_over_the_squared_spectrum(process, width):
    psd = per_sample(process)
    found = modwt_transfer.overlap(psd, 6, width)
    np.testing.assert_array_equal(found, found.T)
    for i, j in ((1, 1), (1, 2), (2, 5), (4, 4), (4, 6)):

        def density(cycles, i=i, j=j):
            gain = squared_gain(cycles, i, width) * squared_gain(cycles, j, width)
            return 2 * gain * psd(cycles) ** 2

        parts = [quad(density, k / 64, (k + 1) / 64, epsabs=0, epsrel=1e-11)[0] for k in range(32)]
        assert found[i - 1, j - 1] == pytest.approx(sum(parts), rel=1e-9)


@pytest.mark.parametrize("process", PROCESSES, ids=lambda p: p.name)
def test_counting_on_a_smooth_is_counting_on_the_sequence(process):
    """Also where the deepest level has fewer coefficients than the smooth takes steps (2 of 2^13 + 1 samples)."""
    psd, count = per_sample(process), 2**13 + 1
    levels = depth(count)
    share, means = modwt_transfer.counted(psd, count, levels, 2, 0)
    first = 4 + modwt_transfer.APART
    smooth_share, smooth_means = modwt_transfer.counted(psd, count, levels, 2, 4)
    np.testing.assert_allclose(np.diag(smooth_share), np.diag(share)[first:], rtol=5e-3)
    deviation = np.sqrt(np.diag(means)[first:])
    scale = np.outer(deviation, deviation)
    np.testing.assert_allclose(smooth_means / scale, means[first:, first:] / scale, atol=5e-3)


@pytest.mark.parametrize("process", PROCESSES, ids=lambda p: p.name)
def test_the_same_question_has_the_same_answer_to_the_last_bit(process):
    psd = per_sample(process)
    first, *others = [modwt_transfer.counted(psd, 2**15, 13, 2, 4) for _ in range(3)]
    for other in others:
        np.testing.assert_array_equal(other, first)
