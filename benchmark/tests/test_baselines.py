import json

import numpy as np
import pytest

from imu_benchmark import baselines
from imu_benchmark.answers import parse, read_entry
from imu_benchmark.case import Case
from imu_benchmark.commitments import read_cases
from imu_benchmark.log import from_samples
from imu_benchmark.schema import FormatError
from imu_benchmark.sealing.noise import fractional, rounded, summed
from imu_benchmark.stream import stream

INTERVAL = 0.02
COUNT = 2**15
NEEDS = {"noise_id": "allantools", "change_points": "ruptures", "classifier": "sklearn"}


def given(signal, *labels, white=1.0):
    """A case of one axis: white noise of deviation ``white`` and a signal."""
    values = white * stream(5, *labels).standard_normal(COUNT) + signal
    return Case("c", (from_samples({"gyro_x": values}, INTERVAL),), None, {})


def found(name, case):
    pytest.importorskip(NEEDS.get(name, "numpy"))
    report = parse(baselines.named(name)(case), name)
    return {one["name"]: one["parameters"] for one in report["effects"]}


def random(draw, *labels):
    return draw(COUNT, stream(6, *labels))


SIGNALS = {
    "none": lambda: 0.0,
    "random_walk": lambda: 0.05 * random(summed, "walk"),
    "bias_instability": lambda: random(lambda count, rng: fractional(count, 1.0, rng), "flicker"),
    "quantization": lambda: 10 * random(rounded, "rounded"),
    "rate_ramp": lambda: np.linspace(0, 30, COUNT),
    "gauss_markov": lambda: _markov(),
    "bias_step": lambda: np.where(np.arange(COUNT) < COUNT / 3, 0.0, 0.3),
    "sinusoid": lambda: 0.2 * np.sin(2 * np.pi * 3.3 * INTERVAL * np.arange(COUNT)),
    "outliers": lambda: 20.0 * (np.arange(COUNT) % 2000 == 77),
}


def _markov():
    ratio, rng = np.exp(-1 / 200), stream(6, "markov")
    values = np.zeros(COUNT)
    for row, kick in enumerate(rng.standard_normal(COUNT - 1)):
        values[row + 1] = ratio * values[row] + np.sqrt(1 - ratio**2) * kick
    return values


@pytest.mark.parametrize(
    ("baseline", "name"),
    [
        *(("allan_slopes", name) for name in ("random_walk", "quantization", "rate_ramp")),
        *(("noise_id", name) for name in ("random_walk", "quantization")),
        *(("gmwm_choice", name) for name in ("quantization", "rate_ramp", "gauss_markov")),
        *(("change_points", name) for name in ("bias_step", "sinusoid", "outliers")),
    ],
)
def test_a_baseline_names_what_it_was_made_for(baseline, name):
    assert name in found(baseline, given(SIGNALS[name](), name))


@pytest.mark.parametrize("baseline", ["nothing", "allan_slopes", "change_points"])
def test_a_baseline_names_nothing_in_white_noise(baseline):
    assert found(baseline, given(0.0, "quiet")) == {}


def test_the_parameters_of_the_allan_slopes_and_of_gmwm_are_those_of_the_signal():
    walk = found("allan_slopes", given(SIGNALS["random_walk"](), "random_walk"))["random_walk"]
    assert walk["density_k"]["value"] == pytest.approx(0.05 / np.sqrt(INTERVAL), rel=0.4)
    noise = found("gmwm_choice", given(SIGNALS["gauss_markov"](), "gauss_markov"))["gauss_markov"]
    assert noise["std"]["value"] == pytest.approx(1.0, rel=0.3)
    assert noise["correlation_time"]["value"] == pytest.approx(200 * INTERVAL, rel=0.5)
    line = found("change_points", given(SIGNALS["sinusoid"](), "sinusoid"))["sinusoid"]
    assert line["frequency"]["value"] == pytest.approx(3.3, abs=2 / (COUNT * INTERVAL))
    assert line["amplitude"]["value"] == pytest.approx(0.2, rel=0.3)
    ramp = found("gmwm_choice", given(SIGNALS["rate_ramp"](), "rate_ramp"))["rate_ramp"]
    assert ramp["slope"]["value"] == pytest.approx(30 / (COUNT * INTERVAL), rel=0.1)


def test_what_the_start_model_has_is_not_named_again():
    walk = given(SIGNALS["random_walk"](), "random_walk")
    known = Case("c", walk.logs, None, {"gyro_x": [{"white_noise": {}}, {"random_walk": {"density_k": 1.0}}]})
    for baseline in ("allan_slopes", "noise_id", "gmwm_choice"):
        if baseline not in NEEDS or pytest.importorskip(NEEDS[baseline]):
            assert "random_walk" not in found(baseline, known)


@pytest.mark.parametrize("baseline", baselines.BASELINES[:-1])
def test_every_case_gets_a_report_that_is_one(baseline, made, tmp_path):
    pytest.importorskip(NEEDS.get(baseline, "numpy"))
    public, _ = made
    baselines.answer_all(baselines.named(baseline), public, tmp_path / baseline)
    entry = read_entry(tmp_path / baseline, read_cases(public))
    assert all(time > 0 for time in entry.seconds.values())
    with pytest.raises(FormatError, match="expected nothing"):
        baselines.answer_all(baselines.named(baseline), public, tmp_path / baseline)


def test_the_classifier_gives_probabilities_and_learns_the_same_from_the_same_seed(monkeypatch):
    pytest.importorskip("sklearn")
    from imu_benchmark.baselines import classifier

    monkeypatch.setattr(classifier, "LENGTHS", {"duration_s": [40, 60], "rates_hz": [25]})
    monkeypatch.setattr(classifier, "TREES", 20)
    one, other = (classifier.trained.__wrapped__(30) for _ in range(2))
    case = given(SIGNALS["sinusoid"](), "sinusoid")
    report = one.report(case)
    assert json.dumps(report) == json.dumps(other.report(case))
    parse(report, "classifier")
    assert sum(report["probabilities"].values()) == pytest.approx(1)
    assert {"sample_loss", "timestamp_jitter", "clock_scale"} >= one.of_time
