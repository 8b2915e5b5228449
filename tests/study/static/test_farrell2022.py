import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from imugap.effects import BiasInstability, Conditions, GaussMarkov, RandomWalk, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation.variances import allan
from imugap.interchange import flicker_bank
from imugap.model import ErrorModel
from imugap.numerics.spectra import allan_from_psd as spectrum
from imugap.stream import stream
from imugap.study.static.farrell2022 import MODELS, TITLES, Readings, bank_alone

TAU = np.geomspace(0.1, 1000, 41)


def readings(**changed):
    """A device whose floor stands well above N and K."""
    return Readings(
        **{"white": 0.05, "walk": 1e-3, "floor": 0.03, "place": 60.0, "shortest": 0.01, "longest": 1e3} | changed
    )


def variance(name, of, tau):
    return spectrum.allan_variance(MODELS[name](of).state_space().psd, tau)


def test_every_model_has_a_title_and_survives_its_yaml(tmp_path):
    assert set(TITLES) == set(MODELS)
    for builder in MODELS.values():
        ErrorModel({"gyro_x": builder(readings())}).write(tmp_path / "model.yaml")
        assert ErrorModel.read(tmp_path / "model.yaml")["gyro_x"] == builder(readings())


@pytest.mark.parametrize(
    ("name", "states"), [("n", 0), ("k", 1), ("nk", 1), ("gm", 1), ("nbk", 2), ("nbk_freed", 2), ("nbk_bank", 6)]
)
def test_state_space_has_the_order_of_the_model(name, states):
    assert len(MODELS[name](readings()).state_space().output) == states


def test_white_noise_is_read_at_one_second_and_the_walk_at_three():
    assert variance("n", readings(), 1.0) == pytest.approx(0.05**2)
    assert variance("k", readings(), 3.0) == pytest.approx(1e-3**2)
    np.testing.assert_allclose(
        variance("nk", readings(), TAU), variance("n", readings(), TAU) + variance("k", readings(), TAU)
    )


def test_top_of_the_gauss_markov_model_is_the_floor():
    of = readings()
    found = np.sqrt(variance("gm", of, of.place * np.geomspace(0.5, 2, 101)))
    assert found.max() == pytest.approx(of.floor, rel=1e-6)
    assert abs(found.argmax() - 50) <= 1


def test_whole_floor_counts_white_noise_and_walk_twice_and_the_freed_one_once():
    of = readings()
    twice, once = (np.sqrt(variance(name, of, of.place)) for name in ("nbk", "nbk_freed"))
    assert once == pytest.approx(of.floor, rel=1e-6)
    assert twice == pytest.approx(np.hypot(of.floor, np.sqrt(variance("nk", of, of.place))), rel=1e-6)
    assert twice > 1.01 * of.floor


def test_where_white_noise_and_walk_need_the_whole_floor_nothing_is_left():
    of = readings(floor=5e-3)
    assert of.left == 0
    np.testing.assert_allclose(variance("nbk_freed", of, TAU), variance("nk", of, TAU), rtol=1e-12)
    np.testing.assert_allclose(variance("nbk_bank", of, TAU), variance("nk", of, TAU), rtol=1e-12)


def test_bank_is_flat_at_what_is_left_within_its_stated_error():
    of = readings()
    density = of.left / np.sqrt(BiasInstability(1.0).allan_variance(1.0))
    stated = flicker_bank.error(bank_alone(of), density, of.shortest, of.longest)
    assert stated < 0.04
    ratio = np.sqrt(spectrum.allan_variance(bank_alone(of).state_space().psd, TAU)) / of.left
    assert np.abs(ratio - 1).max() < stated + 1e-3


@given(st.floats(1e-6, 1e3), st.floats(1e-2, 1e2))
def test_models_scale_with_the_unit_and_with_the_clock(scale, clock):
    one = readings()
    other = readings(white=scale * one.white * clock**0.5, walk=scale * one.walk / clock**0.5, floor=scale * one.floor,
                     place=one.place * clock, shortest=one.shortest * clock, longest=one.longest * clock)  # fmt: skip
    for builder in MODELS.values():
        np.testing.assert_allclose(
            builder(other).allan_variance(TAU * clock), scale**2 * builder(one).allan_variance(TAU), rtol=2e-3
        )


def test_readings_are_those_of_the_curve():
    model, interval = WhiteNoise(0.05) + GaussMarkov(0.03, 20.0) + RandomWalk(2e-3), 0.1
    at = Conditions(interval * np.arange(200_000), interval)
    asd = allan.curve(model.simulate(np.zeros(len(at)), at, 81, "readings"), interval)
    of = Readings.of(asd)
    assert of.white == allan.tangent(asd, allan.LAWS["N"]).value
    assert of.floor == asd["deviation"][asd["error"] < 0.25].min()
    assert asd["deviation"][of.place] == of.floor
    assert (of.shortest, of.longest) == (asd.index[0], asd.index[-1])


def test_a_walk_that_is_not_read_touches_the_rising_end_of_the_curve():
    at = Conditions(0.1 * np.arange(50_000), 0.1)
    asd = allan.curve((WhiteNoise(1.0) + RandomWalk(0.05)).simulate(np.zeros(len(at)), at, 84, "rising"), 0.1)
    of = Readings.of(asd)
    known = asd[asd["error"] < 0.25]
    line = allan.LAWS["K"].deviation(of.walk, known.index)
    assert not allan.tangent(asd, allan.LAWS["K"]).holds
    assert (known["deviation"] / line).min() == pytest.approx(1.0)
    assert 0.02 < of.walk < 0.08


def test_a_curve_without_a_walk_gives_a_model_without_one():
    at = Conditions(0.1 * np.arange(20_000), 0.1)
    asd = allan.curve(AxisModel((WhiteNoise(1.0),)).simulate(np.zeros(len(at)), at, 82, "white"), 0.1)
    assert MODELS["k"](Readings.of(asd)) == AxisModel((RandomWalk(0.0),))


@pytest.mark.slow
@pytest.mark.parametrize("name", MODELS)
def test_simulated_data_have_the_allan_deviation_of_the_spectrum(name):
    """The tutorial's check of a discretised model: eq. 16 against samples of the state space."""
    interval, averaging = 0.1, np.array([30, 200, 1000])
    model = MODELS[name](readings(place=10.0, shortest=0.1)).state_space()
    found = np.array(
        [allan.variance(model.simulate(10_000, interval, stream(83, name, run)), averaging) for run in range(150)]
    )
    truth = spectrum.allan_variance(model.psd, averaging * interval)
    error = found.std(axis=0, ddof=1) / np.sqrt(len(found))
    assert np.all(error < 0.1 * truth)
    assert np.all(np.abs(found.mean(axis=0) - truth) < 4 * error + 2e-3 * truth)
