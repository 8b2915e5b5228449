import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import sici

from imugap.effects import BiasInstability, GaussMarkov, Quantization, RandomWalk, WhiteNoise
from imugap.numerics.spectra.allan_from_psd import allan_variance
from imugap.numerics.state_space import StateSpace

TAU = np.logspace(-3, 4, 15)
AVERAGING = np.array([1, 2, 3, 5, 64, 65, 500, 10_000, 250_000])
PROCESSES = (
    WhiteNoise(0.3),
    RandomWalk(0.2),
    BiasInstability(0.4),
    *(GaussMarkov(0.7, time) for time in (1e-5, 0.2, 30.0, 1e6)),
)
ACCURACY = 1e-8


def names(process):
    return " ".join(map(str, [process.name, *process.parameters().values()]))


@pytest.mark.parametrize("process", PROCESSES, ids=names)
def test_integral_is_the_closed_form_of_every_process(process):
    np.testing.assert_allclose(allan_variance(process.psd, TAU), process.allan_variance(TAU), rtol=ACCURACY)


@pytest.mark.parametrize("process", [*PROCESSES, Quantization(3e-3)], ids=names)
@pytest.mark.parametrize("interval", [0.01, 1.0])
def test_integral_over_the_sampled_spectrum_is_that_of_the_samples(process, interval):
    found = allan_variance(lambda f: process.sampled_psd(f, interval), AVERAGING * interval, interval)
    np.testing.assert_allclose(found, process.sampled_allan_variance(AVERAGING, interval), rtol=ACCURACY)


@pytest.mark.parametrize(
    "model",
    [
        WhiteNoise(0.3) + RandomWalk(0.01),
        RandomWalk(0.2) + GaussMarkov(0.7, 30.0),
        WhiteNoise(0.3) + RandomWalk(0.01) + GaussMarkov(0.7, 30.0) + GaussMarkov(0.1, 1e-3),
    ],
    ids=["N + K", "K + GM", "N + K + 2 GM"],
)
def test_state_space_of_a_composed_model_has_the_allan_variance_of_its_parts(model):
    np.testing.assert_allclose(allan_variance(model.state_space().psd, TAU), model.allan_variance(TAU), rtol=ACCURACY)
    np.testing.assert_allclose(allan_variance(model.psd, TAU), model.allan_variance(TAU), rtol=ACCURACY)


@pytest.mark.parametrize("highest", [0.1, 1.0, 33.3, 1e4])
def test_flicker_with_a_cut_off_is_eq_31(highest):
    """Farrell et al. 2022, eq. 31 (IEEE 952-1997, eq. C.19); below a tenth of the cut-off its terms cancel."""
    tau = TAU[highest * TAU > 0.1]
    x = np.pi * highest * tau
    bracket = np.sin(x) ** 3 / (2 * x**2) * (np.sin(x) + 4 * x * np.cos(x)) - sici(2 * x)[1] + sici(4 * x)[1]
    published = 2 / np.pi * (np.log(2) - bracket)
    np.testing.assert_allclose(allan_variance(BiasInstability(1.0).psd, tau, highest=highest), published, rtol=ACCURACY)


@pytest.mark.parametrize("highest", [1.0, 33.3, 1e4])
def test_spectrum_that_rises_with_the_square_up_to_a_cut_off(highest):
    """int sin^4 = 3u/8 - sin(2u)/4 + sin(4u)/32: the quantization of a continuous angle."""
    tau = TAU[highest * TAU > 0.1]
    u = np.pi * highest * tau
    expected = 4 / (np.pi * tau) ** 3 * (3 * u / 8 - np.sin(2 * u) / 4 + np.sin(4 * u) / 32)
    np.testing.assert_allclose(allan_variance(np.square, tau, highest=highest), expected, rtol=ACCURACY)


@pytest.mark.parametrize("exponent", [-2.95, -2.5, -1.5, -0.3, 0.5])
def test_any_power_law_is_a_power_law(exponent):
    """sigma^2 goes as tau^(-1 - exponent): at every tau the same number, which quadrature of its own kind confirms."""
    scaled = allan_variance(lambda f: f**exponent, TAU, accuracy=1e-7) * TAU ** (1 + exponent)
    np.testing.assert_allclose(scaled, scaled[0], rtol=1e-7)
    lobes = [
        quad(lambda u: u ** (exponent - 2) * np.sin(u) ** 4, k * np.pi, (k + 1) * np.pi, epsrel=1e-10)[0]
        for k in range(400)
    ]
    tail = 3 / 8 * (400 * np.pi) ** (exponent - 1) / (1 - exponent)
    assert scaled[0] == pytest.approx(4 * np.pi ** (-1 - exponent) * (sum(lobes) + tail), rel=1e-6)


@given(st.floats(1.5, 60.0), st.floats(1e-2, 1e2))
def test_resonance_is_followed(quality, tau):
    """The oscillator of natural frequency 1 rad/s; its Allan variance from its autocovariance, in closed form."""
    damping = 1 / quality
    model = StateSpace(
        np.array([[0.0, 1.0], [-1.0, -damping]]), np.diag([0.0, 1.0]), np.array([1.0, 0.0]), 0.0, np.eye(2)
    )
    pole = -damping / 2 + 1j * np.sqrt(1 - damping**2 / 4)
    decay = pole * tau
    # double integral of exp(pole |t|) over neighbouring means, of a covariance Re[weight exp(pole |t|)]
    same = 2 * (np.expm1(decay) - decay) / decay**2
    neighbour = (np.expm1(decay) / decay) ** 2
    weight = (1 - 0.5j * damping / np.sqrt(1 - damping**2 / 4)) / (2 * damping)
    expected = (weight * (same - neighbour)).real
    assert allan_variance(model.psd, tau) == pytest.approx(expected, rel=1e-6, abs=1e-9 / damping)


@given(st.floats(1e-3, 1e3), st.floats(1e-3, 1e3))
def test_result_is_linear_in_the_spectrum(first, second):
    parts = WhiteNoise(first), GaussMarkov(second, 3.0)
    together = allan_variance(lambda f: sum(part.psd(f) for part in parts), 2.0)
    assert together == pytest.approx(sum(allan_variance(part.psd, 2.0) for part in parts), rel=1e-7)


@pytest.mark.parametrize("shape", [(), (3,), (2, 2)])
def test_result_has_the_shape_of_tau(shape):
    assert np.shape(allan_variance(WhiteNoise(1.0).psd, np.ones(shape))) == shape


@pytest.mark.parametrize("exponent", [-3.0, 1.0, 2.0])
def test_an_integral_that_diverges_is_refused(exponent):
    with pytest.raises(ValueError, match="expected a PSD whose integral at tau = 1 s converges"):
        allan_variance(lambda f: f**exponent, 1.0)
