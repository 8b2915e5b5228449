from collections import Counter

import numpy as np
import pytest
from scipy.stats import binom

from imugap.effects import BiasInstability, Conditions, GaussMarkov, Quantization, RandomWalk, RateRamp, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation.model_selection import TERMS, choose, parameters, penalty, title
from imugap.stream import stream

INTERVAL, COUNT = 0.1, 12_000
CLEAR = {
    "white": AxisModel((WhiteNoise(5e-3),)),
    "quantization": WhiteNoise(5e-3) + Quantization(1e-3),
    "flicker": WhiteNoise(5e-3) + BiasInstability(5e-3),
    "walk": WhiteNoise(5e-3) + RandomWalk(1e-3),
    "gauss-markov": WhiteNoise(5e-3) + GaussMarkov(5e-3, 5.0),
    "ramp": WhiteNoise(5e-3) + RateRamp(2e-5),
    "walk and ramp": WhiteNoise(5e-3) + RandomWalk(1e-4) + RateRamp(1e-4),
    "two": WhiteNoise(2e-3) + GaussMarkov(1e-2, 1.0) + GaussMarkov(2e-2, 50.0),
}


def simulate(of, count, *labels):
    return of.simulate(np.zeros(count), Conditions(np.arange(count) * INTERVAL, INTERVAL), 21, *labels)


def kinds(of):
    return tuple(sorted(map(type, of), key=TERMS.index))


@pytest.mark.parametrize("case", CLEAR)
def test_clear_effects_are_named_and_no_other(case):
    of = CLEAR[case]
    found = choose(simulate(of, COUNT, case), INTERVAL)
    assert found.kinds == kinds(of)
    assert set(map(type, found.fit.model)) == set(found.kinds)
    for estimate in found.fit.estimates:
        assert 0 < abs(estimate.value) < np.inf
    assert found.candidates.index[0] == title(found.kinds)
    assert not any(Counter(other) >= Counter(found.kinds) for other in found.alternatives)


@pytest.mark.slow
def test_walk_and_slow_gauss_markov_process_are_not_told_apart():
    """A correlation time ten times the log leaves nothing to tell it from a walk."""
    of = WhiteNoise(5e-3) + GaussMarkov(0.1, 10 * COUNT * INTERVAL)
    found = choose(simulate(of, COUNT, "slow"), INTERVAL)
    assert found.kinds == (WhiteNoise, RandomWalk)
    assert kinds(of) in found.alternatives
    assert found.candidates.loc[title(kinds(of)), "alternative"]


def test_flicker_and_gauss_markov_processes_are_not_told_apart_where_noise_hides_them():
    of = WhiteNoise(5e-3) + BiasInstability(2e-3)
    found = choose(simulate(of, COUNT, "hidden"), INTERVAL)
    assert kinds(of) in (found.kinds, *found.alternatives)
    assert any(GaussMarkov in other for other in found.alternatives)


def test_a_part_is_never_likelier_than_the_whole():
    """Without a ramp, the slope of which is not where the likelihood of the others is greatest."""
    found = choose(simulate(CLEAR["gauss-markov"], COUNT, "nested"), INTERVAL).candidates["log_likelihood"]
    names = {name: Counter(name.split(" + ")) for name in found.index if "rate_ramp" not in name}
    pairs = [(a, b) for a in names for b in names if names[a] < names[b]]
    assert len(pairs) > 10
    for part, whole in pairs:
        assert found[part] < found[whole] + 1e-2


@pytest.mark.slow
@pytest.mark.parametrize("case", ["white", "ramp"])
def test_unit_constant_sign_and_direction_of_time_do_not_matter(case):
    sequence = simulate(CLEAR[case], COUNT, case)
    one, other = choose(sequence, INTERVAL), choose(3.0 - 1e4 * sequence[::-1], INTERVAL)
    assert (other.kinds, other.alternatives) == (one.kinds, one.alternatives)
    columns = ["log_likelihood", "criterion", "held_out"]
    shared = one.candidates.index.intersection(other.candidates.index)
    assert len(shared) > 5
    lead, same = (found.candidates.loc[shared, columns].diff().dropna() for found in (one, other))
    np.testing.assert_allclose(lead, same, atol=0.05)


def test_what_shows_in_one_part_of_the_log_alone_is_not_named():
    """A Gauss-Markov disturbance of one sixth of the log fits the whole, but predicts none of the other parts."""
    burst = simulate(AxisModel((GaussMarkov(1e-2, 2.0),)), COUNT, "burst") * (np.arange(COUNT) // 2000 == 2)
    found = choose(simulate(CLEAR["white"], COUNT, "calm") + burst, INTERVAL)
    assert found.candidates.index[0] != "white_noise"
    assert found.candidates["overfits"].iloc[0]
    assert found.kinds == (WhiteNoise,)


def test_frequencies_above_the_highest_have_no_say():
    """White noise through a filter is white below its cut-off."""
    noise = np.convolve(stream(1, "filtered").standard_normal(COUNT + 2), np.ones(3) / 3, "valid")
    assert WhiteNoise not in choose(noise, INTERVAL).kinds
    assert choose(noise, INTERVAL, highest=0.3).kinds == (WhiteNoise,)


def test_candidates_are_described():
    found = choose(simulate(CLEAR["walk"], COUNT, "described"), INTERVAL)
    table = found.candidates
    assert table["criterion"].is_monotonic_decreasing
    np.testing.assert_allclose(table["log_likelihood"] - table["criterion"], penalty(0.95) * table["parameters"])
    assert table.loc[title(found.kinds), "held_out_error"] == 0
    assert (table["held_out_error"].drop(title(found.kinds)) > 0).all()
    assert list(table.index[table["alternative"]]) == [title(other) for other in found.alternatives]
    assert parameters((WhiteNoise, GaussMarkov, RateRamp)) == 4


def test_a_higher_level_costs_more():
    assert 0 < penalty(0.5) < penalty(0.95) < penalty(0.99)


def test_cost_is_the_limit_of_the_maximum_of_a_density():
    """Of 2 (log-likelihood gained) by a variance added to known white noise, exceeded once in a hundred times."""
    squares = stream(2, "limit").chisquare(500, 200_000) / 500
    gain = np.where(squares > 1, 500 * (squares - 1 - np.log(squares)), 0.0)
    share = np.mean(gain > 2 * penalty(0.95))
    assert abs(share - 0.01) < 0.002


@pytest.mark.parametrize("sequence", [np.arange(255.0) % 7, np.ones(1000), np.r_[np.nan, np.arange(999.0)]])
def test_log_without_information_is_refused(sequence):
    with pytest.raises(ValueError, match="expected"):
        choose(sequence, INTERVAL)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "axes"), [("white", 1), ("walk", 1), ("gauss-markov", 1), ("flicker", 1), ("white", 6)]
)
def test_false_additions_are_as_rare_as_the_level_says(case, axes):
    """Names that are not there, in 40 logs: no more than the binomial law of 5 % gives once in a thousand times."""
    runs, of, most = 40, CLEAR[case], binom.isf(1e-3, 40, 0.05 / axes)
    found = [choose(simulate(of, 6000, "false", case, run), INTERVAL, axes=axes).kinds for run in range(runs)]
    wrong = sum(bool(Counter(names) - Counter(kinds(of))) for names in found)
    assert wrong <= most
    assert sum(names == kinds(of) for names in found) >= runs - most


def test_what_one_axis_may_have_by_chance_is_not_selected_on_one_of_six():
    """A log of white noise that has flicker noise by the level of one axis."""
    noise = simulate(CLEAR["white"], 6000, "several", 3)
    assert choose(noise, INTERVAL).kinds != (WhiteNoise,)
    assert choose(noise, INTERVAL, axes=6).kinds == (WhiteNoise,)
