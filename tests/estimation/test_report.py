import numpy as np
import pytest

from imugap.effects import (
    CATALOGUE,
    BiasInstability,
    Conditions,
    GaussMarkov,
    Quantization,
    RandomWalk,
    RateRamp,
    WhiteNoise,
)
from imugap.effects.effect import AxisModel
from imugap.estimation import maximum_likelihood
from imugap.estimation.model_selection import TERMS
from imugap.estimation.report import EstimatorSettings, Method, curves, estimate_axis, kinds_of, table, to_json
from imugap.estimation.variances import allan
from imugap.estimation.variances.wavelet_variance import EFFICIENCY
from imugap.log import from_samples

INTERVAL, COUNT = 0.02, 6000


def simulate(of, *labels, count=COUNT):
    return of.simulate(np.zeros(count), Conditions(np.arange(count) * INTERVAL, INTERVAL), 31, *labels)


def estimated(samples, *kinds, axis="gyro_x", **settings):
    """Estimate the parameters of kinds of effects, or of those that are chosen where none is given."""
    return estimate_axis(axis, samples, INTERVAL, EstimatorSettings(kinds or None, **settings))


def test_record_is_strict_json_of_the_schema_with_catalogue_names_and_units(judge, validated):
    of = WhiteNoise(1e-3) + GaussMarkov(1e-2, 1e4)
    found = [estimated(simulate(of, axis), WhiteNoise, GaussMarkov, axis=axis) for axis in ("gyro_z", "accel_x")]
    records = validated(to_json(found))
    for record, unit in zip(records, ("rad/s", "m/s^2"), strict=True):
        for term in record["terms"]:
            units = CATALOGUE[term["name"]].units(unit)
            assert {name: parameter["unit"] for name, parameter in term["parameters"].items()} == units
        assert record["terms"][1]["parameters"]["correlation_time"]["high"] is None
        assert "gauss_markov 1 correlation_time (lower bound)" in record["verdict"]
        assert record["verdict"].startswith(judge)


def test_repeated_terms_stay_apart(judge):
    of = WhiteNoise(1e-3) + GaussMarkov(1e-2, 0.1) + GaussMarkov(1e-2, 10.0)
    terms = estimated(simulate(of, "two"), WhiteNoise, GaussMarkov, GaussMarkov).record()["terms"]
    assert [term["name"] for term in terms] == ["white_noise", "gauss_markov", "gauss_markov"]
    times = [term["parameters"]["correlation_time"]["value"] for term in terms[1:]]
    assert times == sorted(times)
    assert times[0] < 1 < times[1]


def test_slope_is_a_term(judge):
    sequence = simulate(WhiteNoise(1e-3) + RateRamp(-1e-4), "slope")
    term = estimated(sequence, WhiteNoise, RateRamp).record()["terms"][-1]
    assert term["name"] == "rate_ramp"
    slope = term["parameters"]["slope"]
    assert slope["low"] < -1e-4 < slope["high"] < 0
    assert slope["unit"] == "rad/s/s"


def test_terms_are_chosen_where_none_are_given(judge):
    found = estimated(simulate(WhiteNoise(1e-3) + RandomWalk(1e-3), "auto"))
    assert [term["name"] for term in found.record()["terms"]] == ["white_noise", "random_walk"]
    assert "do not separate it from: white_noise + gauss_markov" in found.verdict()


def test_noise_through_a_filter_is_said_to_look_like_a_gauss_markov_process(judge):
    of = AxisModel((GaussMarkov(1.0, 2 * INTERVAL),))
    assert "may be an output filter" in estimated(simulate(of), axis="accel_y").verdict()
    assert "output filter" not in estimated(simulate(of + WhiteNoise(0.1)), axis="accel_y").verdict()


def stand_in(monkeypatch, name, sequence):
    """Let the module of that name give the estimates of likelihood, and return its calls."""
    calls = []

    def fit(*args, **kwargs):
        calls.append((args[2:], kwargs))
        return maximum_likelihood.fit(sequence, INTERVAL, (WhiteNoise,))

    monkeypatch.setattr(f"imugap.estimation.{name}.fit", fit)
    return calls


@pytest.mark.parametrize("robust", [False, True])
def test_wavelet_method_gets_the_random_processes_and_the_ramp_apart(judge, monkeypatch, robust):
    sequence = simulate(AxisModel((WhiteNoise(1e-3),)))
    calls = stand_in(monkeypatch, "gmwm.estimator", sequence)
    estimated(sequence, WhiteNoise, GaussMarkov, GaussMarkov, RateRamp, method=Method.WAVELET, robust=robust)
    (((random, options), _),) = calls
    assert random == (WhiteNoise, GaussMarkov, GaussMarkov)
    assert options.ramp is True
    assert options.efficiency == (EFFICIENCY if robust else 1.0)


def test_allan_method_gets_the_ramp_among_the_kinds(judge, monkeypatch):
    sequence = simulate(AxisModel((WhiteNoise(1e-3),)))
    calls = stand_in(monkeypatch, "variances.allan_slopes", sequence)
    estimated(sequence, WhiteNoise, RateRamp, method=Method.ALLAN)
    assert calls == [(((WhiteNoise, RateRamp), 0.95), {})]


def test_chosen_terms_are_estimated_by_the_method_asked_for(judge, monkeypatch):
    sequence = simulate(AxisModel((WhiteNoise(1e-3),)))
    calls = stand_in(monkeypatch, "variances.allan_slopes", sequence)
    assert estimated(sequence, method=Method.ALLAN).method == Method.ALLAN
    assert calls[0][0][0] == (WhiteNoise,)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"robust": True}, "robust: expected the method wavelet; found likelihood"),
        ({"kinds": (WhiteNoise,), "method": Method.ALLAN, "highest": 1.0}, "highest: expected the method likelihood"),
        ({"kinds": (WhiteNoise, WhiteNoise)}, "terms: expected only gauss_markov more than once"),
        ({"kinds": (RateRamp,)}, "terms: expected at least one random process; found rate_ramp"),
        ({"kinds": ()}, "terms: expected at least one random process; found none"),
        ({"kinds": (GaussMarkov, GaussMarkov), "method": Method.ALLAN}, "terms: expected at most one gauss_markov"),
    ],
)
def test_what_a_method_cannot_do_is_refused(options, message):
    with pytest.raises(ValueError, match=message):
        EstimatorSettings(**options)


def test_fault_says_the_axis(judge):
    with pytest.raises(ValueError, match="accel_z: likelihood: expected finite samples that vary"):
        estimated(np.ones(1000), WhiteNoise, axis="accel_z")


def test_names_are_those_of_the_terms():
    assert kinds_of([kind.name for kind in TERMS]) == TERMS
    assert kinds_of(["gauss_markov", "gauss_markov"]) == (GaussMarkov, GaussMarkov)
    with pytest.raises(
        ValueError, match=r"terms: expected a known name \(did you mean bias_instability\?\); found 'bias_instabilty'"
    ):
        kinds_of(["white_noise", "bias_instabilty"])
    with pytest.raises(ValueError, match=r"terms: expected one of quantization, .*; found '1/f'"):
        kinds_of(["1/f"])


def test_table_holds_every_parameter_once(judge):
    sequence = simulate(AxisModel((WhiteNoise(1e-3),)))
    rows = table([estimated(sequence, Quantization, WhiteNoise, BiasInstability, GaussMarkov, RateRamp)])
    assert list(rows["parameter"]) == ["q", "density", "density_b", "std", "correlation_time", "slope"]
    assert (rows["axis"] == "gyro_x").all()
    assert rows["unit"].notna().all()


def test_curves_hold_the_log_and_where_the_model_expects_it(judge):
    """The right model's band holds about 95 % of the points; one ten times too small holds none."""
    of = WhiteNoise(1e-3) + RandomWalk(1e-3)
    log = from_samples({"gyro_x": simulate(of, "curve"), "accel_y": simulate(of, "other")}, INTERVAL)
    found = [estimated(log[axis].to_numpy(), WhiteNoise, RandomWalk, axis=axis) for axis in log.columns]
    rows = curves(found)
    assert list(rows["axis"].unique()) == ["gyro_x", "accel_y"]
    for axis, one in rows.groupby("axis"):
        np.testing.assert_array_equal(one["deviation"], allan.curve(log[axis], INTERVAL)["deviation"])
        assert (one["low"] < one["model"]).all()
        assert (one["model"] < one["high"]).all()
    inside = (rows["low"] < rows["deviation"]) & (rows["deviation"] < rows["high"])
    assert inside.mean() > 0.8
