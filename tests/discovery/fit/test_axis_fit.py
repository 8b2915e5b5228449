import numpy as np
import pytest
from tests.discovery.simulated import COUNT, INTERVAL, behind, fitted, sequence

from imugap.discovery.fit.axis_fit import jacobian
from imugap.discovery.fit.description import Entry
from imugap.effects import BiasStep, Outliers, OutputFilter, Quantization, RateRamp, Sinusoid, WarmUp


def test_ramp_in_white_noise_is_that_of_least_squares():
    data = sequence(RateRamp(1e-6))
    found = fitted(data, Entry(RateRamp(0.0), ("slope",)))
    slope = np.polynomial.polynomial.polyfit(data.conditions.time, data.values, 1)[1]
    assert found.description.terms[0].effect.slope == pytest.approx(slope, rel=1e-6)
    error = np.sqrt(12 * found.variance[0] / COUNT) / (COUNT * INTERVAL)
    assert np.sqrt(found.covariance[0, 0]) == pytest.approx(error, rel=1e-3)


@pytest.mark.parametrize(
    "effect",
    [Sinusoid(1.3, 2e-3, 0.4), WarmUp(2e-3, 90.0), BiasStep(300.0, 1e-3), RateRamp(1e-6)],
    ids=lambda e: e.name,
)
def test_slopes_are_difference_quotients(effect):
    data = sequence(count=2000)
    free = tuple(effect.slopes(data.conditions))
    columns = jacobian((Entry(effect, free),), data)
    for name, column in zip(free, columns.T, strict=True):
        step = 1e-6 * max(abs(getattr(effect, name)), 1e-3)
        above, below = (
            type(effect)(**(effect.parameters() | {name: getattr(effect, name) + side})).sample(data.conditions, None)
            for side in (step, -step)
        )
        np.testing.assert_allclose((above - below) / (2 * step), column, rtol=1e-4, atol=1e-6 * np.abs(column).max())


@pytest.mark.parametrize(("cutoff", "order"), [(1.2, 3), (2.0, 4), (6.0, 4), (3.0, 1)])
@pytest.mark.parametrize("count", [6000, 24_000])
def test_what_a_steep_filter_leaves_is_not_taken_for_noise(cutoff, order, count):
    """Towards half the rate the cosine transform shows what leaks from the ends of the log, and nothing else."""
    data, smooth = sequence(count=count), OutputFilter(cutoff, order)
    output = behind(data, smooth)
    plainly, grainy = fitted(output, smooth), fitted(output, Quantization(1e-7), smooth)
    assert grainy.log_likelihood - plainly.log_likelihood < 3
    assert plainly.description.noise.output_filter.cutoff == pytest.approx(cutoff, rel=0.03)


def test_an_outlier_in_coloured_noise_is_one_sample():
    data = sequence(Quantization(3e-4), Outliers(0.004, 0.06), label="coloured")
    tails = fitted(data, Quantization(3e-4)).tails
    assert tails.clustered > np.log(0.01)
    assert 0.003 < tails.probability < 0.005


def test_an_effect_without_the_slope_of_a_free_parameter_is_told():
    data = sequence(count=100)
    entry = Entry(Sinusoid(1.0, 1.0, 0.5), ("amplitude", "growth"))
    with pytest.raises(ValueError, match="sinusoid: slopes: expected those of amplitude, growth; found"):
        jacobian([entry], data)
