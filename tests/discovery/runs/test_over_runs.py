"""Several runs of a device: the parameters of all together, their scatter between runs, and what does not recur."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom, chi2
from tests.discovery import simulated

from imugap import log
from imugap.discovery.device import Settings, discover, leave_one_out
from imugap.discovery.fit.axis_fit import fit, log_score
from imugap.discovery.fit.description import Description
from imugap.discovery.preparation.prepare import prepare
from imugap.discovery.runs.over_runs import fit_over_runs, not_needed, not_recurring, search_over_runs
from imugap.discovery.search.intervals import intervals
from imugap.discovery.verdict import verdict
from imugap.effects import GaussMarkov, RandomWalk, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.model import ErrorModel
from imugap.stream import stream

WALK = RandomWalk(5e-4)
PROCESS = GaussMarkov(2e-3, 4.0)
RUNS, COUNT, CASES = 5, 3000, 60


def run(label, *effects, white=simulated.WHITE):
    return simulated.sequence(*effects, white=white, count=COUNT, label=label)


def fits(case, scatter):
    """The runs of a device whose white noise and random walk scatter from run to run by a factor exp(``scatter``)."""
    found, rng = [], stream(3, "over runs", case, scatter)
    for number in range(RUNS):
        white, walk = np.exp(scatter * rng.standard_normal(2))
        sizes = WhiteNoise(simulated.WHITE.density * white), RandomWalk(WALK.density_k * walk)
        found.append(simulated.fitted(run(f"{case} {scatter} {number}", sizes[1], white=sizes[0]), WALK))
    return found


def test_equal_runs_give_the_interval_of_their_whole_length():
    runs = fits(0, 0.0)
    together = fit_over_runs(runs)
    for index in range(2):
        (own,), (of_all,) = (intervals(one, index).values() for one in (runs[0], together))
        ratio = np.log(of_all.high / of_all.low) / np.log(own.high / own.low)
        assert 0.9 / np.sqrt(RUNS) < ratio < 1.6 / np.sqrt(RUNS)
    assert together.description.noise.effects != runs[0].description.noise.effects
    assert together.description.terms == runs[0].description.terms


@pytest.mark.slow
@pytest.mark.parametrize("scatter", [0.0, 0.3])
def test_intervals_hold_the_mean_of_the_device_and_the_covariance_the_parameters_of_a_run(scatter):
    truth = np.log([simulated.WHITE.density, WALK.density_k])
    held, squares = 0, []
    for case in range(CASES):
        together = fit_over_runs(fits(case, scatter))
        ends = [next(iter(intervals(together, index).values())) for index in range(2)]
        held += sum(end.low < np.exp(one) < end.high for end, one in zip(ends, truth, strict=True))
        another = truth + scatter * stream(4, "another", case, scatter).standard_normal(2)
        off = together.noise.noise.theta() - another
        squares.append(off @ np.linalg.solve(together.noise.covariance, off))
    # with five runs an interval by the normal law holds its value in 86 to 95 % of cases (Student, 4 degrees)
    assert binom.ppf(1e-3, 2 * CASES, 0.86) <= held
    within = np.count_nonzero(np.array(squares) < chi2.ppf(0.95, 2))
    assert within >= binom.ppf(1e-3, CASES, 0.8)
    if scatter:
        assert within <= binom.ppf(0.999, CASES, 0.95)


@pytest.mark.parametrize(("recurs", "told"), [(True, None), (False, "gauss_markov")])
def test_a_process_that_only_the_first_run_has_does_not_recur(recurs, told):
    first = simulated.fitted(run("first", WALK, PROCESS), WALK, PROCESS)
    of_others = (WALK, PROCESS) if recurs else (WALK,)
    others = [simulated.fitted(run(f"other {number}", *of_others), WALK, PROCESS) for number in range(3)]
    effect = not_recurring(first, others)
    assert (None if effect is None else effect.name) == told


FAINT = GaussMarkov(5e-4, 4.0)


def over_runs(*runs, beside=()):
    """What all runs together show beyond white noise and the processes ``beside``."""
    return search_over_runs([simulated.fitted(one, *beside) for one in runs], simulated.KINDS, simulated.LOG_ALPHA)


def test_a_process_too_faint_for_each_run_is_found_in_all_of_them():
    runs = [run(f"faint {number}", FAINT) for number in range(10)]
    assert not over_runs(*runs[:2]).added
    found = over_runs(*runs)
    assert [trial.effect.slow for trial in found.added] == [True]
    (finding,) = found.findings()
    assert finding.effects["gyro_x"] == found.fit.description.noise.effects[-1]
    plain, others = fit_over_runs([simulated.fitted(one) for one in runs]), [run(f"new {i}", FAINT) for i in range(5)]
    gains = [log_score(one, found.fit.description) - log_score(one, plain.description) for one in others]
    assert sum(gains) > 0.0


def test_a_process_of_one_run_alone_is_not_one_of_the_device():
    runs = [run("one", PROCESS), *(run(f"rest {number}") for number in range(4))]
    assert not over_runs(*runs).added


@pytest.mark.slow
def test_runs_without_a_further_process_seldom_show_one():
    some = (over_runs(*(run(f"null {case} {number}") for number in range(3))).added for case in range(200))
    assert sum(map(bool, some)) <= binom.ppf(0.999, 200, len(simulated.KINDS) * np.exp(simulated.LOG_ALPHA))


def test_a_process_of_the_first_run_is_not_needed_beside_what_all_runs_show():
    runs = [run(f"stands in {number}", PROCESS) for number in range(RUNS)]
    assert not_needed(over_runs(*runs, beside=(WALK,)), simulated.LOG_ALPHA).name == "random_walk"
    assert not_needed(over_runs(*runs, beside=(PROCESS,)), simulated.LOG_ALPHA) is None


def test_an_effect_of_the_start_model_is_not_asked():
    start = Description.known(simulated.WHITE, PROCESS)
    first = fit(run("known", PROCESS), start)
    assert not_recurring(first, [replace(first, sequence=run("other"))]) is None


INTERVAL, LENGTH = 0.1, 6000
DEVICE = (WhiteNoise(1e-3), RandomWalk(3e-4))
KINDS = (WhiteNoise, RandomWalk, GaussMarkov)


def logs(count, *of_first):
    """Runs of a device, the first with further processes."""
    still = log.from_samples({"gyro_x": np.zeros(LENGTH)}, INTERVAL)
    models = (ErrorModel({"gyro_x": AxisModel((*DEVICE, *(() if run else of_first)))}) for run in range(count))
    return [model.simulate(still, 5, "device", run) for run, model in enumerate(models)]


@pytest.fixture(scope="module")
def found():
    """What is found on five runs of a device, of which the first has a further process."""
    return discover(logs(5, GaussMarkov(2e-3, 2.0)), Settings(catalogue=KINDS))


def test_a_process_of_the_first_run_alone_is_not_in_the_model_of_the_device(found):
    withheld = [(one.axis, one.name, one.reason) for one in found.withheld]
    assert ("gyro_x", "gauss_markov", "further runs are less likely with it") in withheld
    assert not any(isinstance(effect, GaussMarkov) for effect in found.final["gyro_x"])
    assert "Random processes have the values and intervals of all 5 runs together." in verdict(found)


def test_the_finding_is_the_effect_of_the_model_and_its_interval_that_of_all_runs(found):
    (finding,) = (one for one in found.findings if one.name == "random_walk")
    (effect,) = (effect for effect in found.final["gyro_x"] if isinstance(effect, RandomWalk))
    ends = finding.parameters["density_k"]
    assert finding.effects["gyro_x"] == effect
    assert ends.value == effect.density_k
    assert ends.low < 3e-4 < ends.high
    assert ends.high / ends.low < 4.0  # the walk of the first run stands for its further process, too


def test_each_run_is_compared_with_what_the_others_say():
    runs = logs(3)
    compared = list(leave_one_out(runs, [*map(prepare, runs)], Settings(catalogue=KINDS), [None] * 3))
    for out, one in enumerate(compared):
        np.testing.assert_array_equal(one.measured["gyro_x"], runs[out]["gyro_x"].iloc[: len(one.measured)])
    walks = {one.after.model["gyro_x"].stochastic() for one in compared}
    assert len(walks) == len(runs)
