import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from imugap.effects import BiasInstability, Conditions, GaussMarkov
from imugap.effects.effect import AxisModel
from imugap.estimation.variances import allan
from imugap.interchange import flicker_bank
from imugap.numerics.spectra import allan_from_psd as spectrum
from imugap.stream import stream


@pytest.mark.parametrize(("decades", "states"), [(1, 2), (2, 1), (3, 3), (4, 5)])
def test_stated_error_is_that_of_the_integrated_spectrum_between_the_points_too(decades, states):
    bank = flicker_bank.bank(2.0, 0.1, 0.1 * 10**decades, states)
    tau = np.geomspace(0.1, 0.1 * 10**decades, 333)
    deviation = np.sqrt(spectrum.allan_variance(bank.state_space().psd, tau) / BiasInstability(2.0).allan_variance(tau))
    stated = flicker_bank.error(bank, 2.0, 0.1, 0.1 * 10**decades)
    assert np.abs(deviation - 1).max() == pytest.approx(stated, rel=0.02)


@pytest.mark.parametrize("decades", [1, 2, 3, 4])
def test_more_states_make_the_error_smaller_and_more_decades_larger(decades):
    errors = [
        flicker_bank.error(flicker_bank.bank(1.0, 1.0, 10.0**decades, n), 1.0, 1.0, 10.0**decades)
        for n in range(1, decades + 3)
    ]
    assert np.all(np.diff(errors) < 0)
    wider = flicker_bank.bank(1.0, 1.0, 10.0 ** (decades + 1), decades)
    assert flicker_bank.error(wider, 1.0, 1.0, 10.0 ** (decades + 1)) > errors[decades - 1]


@pytest.mark.parametrize(("decades", "states"), [(2, 2), (3, 4)])
def test_error_is_the_same_on_both_sides_as_of_a_best_approximation(decades, states):
    bank = flicker_bank.bank(1.0, 1.0, 10.0**decades, states)
    tau = np.geomspace(1, 10.0**decades, 400)
    ratio = np.sqrt(bank.allan_variance(tau) / BiasInstability(1.0).allan_variance(tau)) - 1
    assert ratio.max() == pytest.approx(-ratio.min(), rel=0.03)
    turns = np.flatnonzero(np.diff(np.sign(np.diff(ratio))))
    assert len(turns) >= 2 * states - 2  # equal ripple


@pytest.mark.parametrize("change", [0.97, 1.03])
def test_no_variance_can_be_changed_for_the_better(change):
    bank = flicker_bank.bank(1.0, 1.0, 1e3, 3)
    best = flicker_bank.error(bank, 1.0, 1.0, 1e3)
    for k, process in enumerate(bank):
        effects = list(bank)
        effects[k] = GaussMarkov(change * process.std, process.correlation_time)
        assert flicker_bank.error(AxisModel(tuple(effects)), 1.0, 1.0, 1e3) > best


@given(st.floats(1e-6, 1e3), st.floats(1e-3, 1e3))
@settings(max_examples=20)
def test_bank_scales_with_b_and_with_the_range(density_b, shortest):
    unit, scaled = flicker_bank.bank(1.0, 1.0, 1e2, 2), flicker_bank.bank(density_b, shortest, shortest * 1e2, 2)
    for one, other in zip(unit, scaled, strict=True):
        assert other.std == pytest.approx(density_b * one.std, rel=1e-3)
        assert other.correlation_time == pytest.approx(shortest * one.correlation_time, rel=1e-3)


def test_one_state_is_the_tutorials_with_the_error_shared():
    """One decade: the top is nearly flat, and its height lies above 0.664 B by what the ends lie below."""
    (process,) = flicker_bank.bank(1.0, 1.0, 10.0, 1)
    assert process.correlation_time == pytest.approx(np.sqrt(10) / 1.89, rel=0.1)
    assert flicker_bank.error(flicker_bank.bank(1.0, 1.0, 10.0, 1), 1.0, 1.0, 10.0) == pytest.approx(0.099, abs=1e-3)


@pytest.mark.slow
def test_simulated_bank_has_the_allan_deviation_of_flicker():
    bank, interval = flicker_bank.bank(1.0, 0.5, 50.0, 3), 0.1
    averaging = np.array([20, 80, 320])
    at = Conditions(interval * np.arange(20_000), interval)
    found = np.array(
        [
            allan.variance(sum(effect.sample(at, stream(31, run, effect)) for effect in bank), averaging)
            for run in range(100)
        ]
    )
    flat = BiasInstability(1.0).allan_variance(1.0)
    error = found.std(axis=0, ddof=1) / np.sqrt(len(found))
    # the bank is within 1 % in deviation
    assert np.all(np.abs(found.mean(axis=0) - flat) < 4 * error + 0.02 * flat)


@pytest.mark.parametrize(
    ("arguments", "found"),
    [((1.0, 0.0, 1.0, 1), "0 and 1"), ((1.0, 2.0, 1.0, 1), "2 and 1"), ((1.0, 1.0, 2.0, 0), "0")],
)
def test_an_impossible_bank_is_refused(arguments, found):
    with pytest.raises(ValueError, match=f"flicker bank: expected .* found {found}"):
        flicker_bank.bank(*arguments)
