"""Systematic effects that every run of a device repeats, and that none of them shows."""

import numpy as np
import pytest
from scipy.stats import binom
from tests.discovery import simulated

from imugap import log
from imugap.discovery.device import Settings, discover
from imugap.discovery.fit.description import Entry
from imugap.discovery.runs.over_runs import better_over_runs, search_over_runs
from imugap.discovery.runs.shared_term import SharedTerm, fit_to_runs
from imugap.discovery.search.intervals import repeats
from imugap.discovery.search.search import Trial
from imugap.effects import (
    BiasInstability,
    BiasStep,
    Chirp,
    RandomWalk,
    RateRamp,
    ScaleFactor,
    Temperature,
    WarmUp,
    WhiteNoise,
)
from imugap.effects.effect import AxisModel, Start
from imugap.log import TEMPERATURE
from imugap.model import ErrorModel
from imugap.stream import stream

COUNT, RUNS, CASES = 3000, 8, 60
TIME = simulated.INTERVAL * np.arange(COUNT)
FAINT = Temperature(1.8e-4, 25.0)
"""Its gain of log-likelihood is about 4 in one run."""


def warming(*labels):
    """The temperature of a run: a device that warms up, in a room whose temperature swings."""
    phase = stream(7, "warming", *labels).uniform(0, 2 * np.pi)
    return 25.0 + 5.0 * (1 - np.exp(-TIME / 30.0)) + np.sin(2 * np.pi * TIME / 80.0 + phase)


def run(label, *effects):
    return simulated.sequence(*effects, count=COUNT, label=label, temperature=warming(label))


def over_runs(*runs):
    return search_over_runs([simulated.fitted(one) for one in runs], simulated.KINDS, simulated.LOG_ALPHA)


def test_what_repeats_is_the_same_function_of_time_or_temperature_in_every_run():
    assert all(map(repeats, (Temperature, RateRamp, WarmUp)))
    assert not any(map(repeats, (BiasStep, Chirp, ScaleFactor, RandomWalk)))


@pytest.mark.parametrize("effect", [FAINT, Temperature(0.0, 25.0, rate=3.7e-3), RateRamp(6e-6)])
def test_an_effect_too_faint_for_each_run_is_named_from_all_of_them(effect):
    runs = [run(f"faint {number}", effect) for number in range(RUNS)]
    assert not over_runs(runs[0]).terms
    assert not over_runs(*runs[:2]).terms
    found = over_runs(*runs)
    (finding,) = (term.finding("gyro_x") for term in found.terms)
    assert finding.name == effect.name
    ((name, truth),) = ((name, value) for name, value in effect.parameters().items() if value and name != "reference")
    assert finding.parameters[name].low < truth < finding.parameters[name].high
    assert finding.effects["gyro_x"] in found.fit.description.effects()
    assert effect.name not in dict(finding.alternatives)


def test_an_interval_stays_within_what_a_parameter_can_be():
    entry = Entry(WarmUp(1e-3, 5.0), ("amplitude", "time_constant"))
    trial = Trial(entry.effect, simulated.fitted(run("limits")), 20.0, 2, 1.0)
    ends = SharedTerm(entry, np.diag([1e-6, 100.0]), trial).finding("gyro_x").parameters
    assert ends["time_constant"].low >= 0.0
    assert ends["amplitude"].low < 0.0 < ends["amplitude"].high


def test_an_effect_of_one_run_alone_is_not_repeated():
    runs = [run("alone", Temperature(1e-3, 25.0)), *(run(f"none {number}") for number in range(4))]
    assert not over_runs(*runs).terms


def test_opposite_signs_are_not_repeated():
    signs = [Temperature(sign * 5e-4, 25.0) for sign in (1, -1, 1, -1)]
    assert not over_runs(*(run(f"sign {number}", one) for number, one in enumerate(signs))).terms


def test_runs_without_a_temperature_have_no_answer_to_it():
    runs = [simulated.sequence(count=COUNT, label=f"none {number}") for number in range(3)]
    assert not over_runs(run("with"), *runs).terms


@pytest.mark.slow
@pytest.mark.parametrize("scatter", [0.0, 1e-4])
def test_intervals_hold_the_value_of_the_device(scatter):
    held = 0
    for case in range(CASES):
        values = 1.8e-4 + scatter * stream(8, "scatter", case, scatter).standard_normal(RUNS)
        runs = [run(f"{case} {i} {scatter}", Temperature(float(value), 25.0)) for i, value in enumerate(values)]
        start = Start(Temperature(0.0, 25.0), ("coefficient",))
        entry, covariance = fit_to_runs([simulated.fitted(one) for one in runs], start)
        held += abs(entry.effect.coefficient - 1.8e-4) < 1.96 * np.sqrt(covariance[0, 0])
    # the scatter of eight runs is little known: by the normal law 91 % of the intervals hold (Student, 7 degrees)
    assert binom.ppf(1e-3, CASES, 0.91) <= held
    assert held <= binom.ppf(0.999, CASES, 0.99)


@pytest.mark.slow
def test_the_interval_holds_beside_noise_that_no_test_shows():
    """Faint flicker noise is not significant, and most of the error of the coefficient is its."""
    found, held = 0, 0
    for case in range(CASES // 2):
        runs = [run(f"beside {case} {i}", BiasInstability(2e-4), Temperature(4e-4, 25.0)) for i in range(RUNS)]
        for term in over_runs(*runs).terms:
            ends = term.finding("gyro_x").parameters["coefficient"]
            found += term.entry.effect.name == "temperature"
            held += term.entry.effect.name == "temperature" and ends.low < 4e-4 < ends.high
    assert found >= 0.9 * CASES // 2
    assert binom.ppf(1e-3, found, 0.95) <= held


def test_what_one_run_takes_for_another_effect_is_told_by_all():
    truth = [run(f"told {number}", Temperature(8e-4, 25.0)) for number in range(RUNS)]
    taken = [simulated.fitted(one, WarmUp(-4e-3, 30.0)) for one in truth]
    assert better_over_runs(taken, simulated.KINDS, simulated.LOG_ALPHA).name == "warm_up"
    taken = [simulated.fitted(one, Temperature(8e-4, 25.0)) for one in truth]
    assert better_over_runs(taken, simulated.KINDS, simulated.LOG_ALPHA) is None


def test_discovery_on_all_runs_names_what_the_first_does_not_show():
    def logs(count):
        for number in range(count):
            still = log.from_samples({"gyro_x": np.zeros(COUNT)}, simulated.INTERVAL)
            still[TEMPERATURE] = warming("device", number)
            yield ErrorModel({"gyro_x": AxisModel((WhiteNoise(1e-3), FAINT))}).simulate(still, 6, "device", number)

    settings = Settings(catalogue=(WhiteNoise, RandomWalk, Temperature, RateRamp), replicates=19, simulations=4)
    runs = list(logs(RUNS))
    assert not discover(runs[:1], settings).findings
    found = discover(runs, settings)
    (finding,) = found.findings
    assert finding.name == "temperature"
    assert finding.effects["gyro_x"] in found.final["gyro_x"].effects
    assert finding.probabilities["temperature"] > 0.5
