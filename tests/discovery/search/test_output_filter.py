from dataclasses import replace

import numpy as np
import pytest
from tests.discovery.simulated import (
    COUNT,
    INTERVAL,
    KINDS,
    LOG_ALPHA,
    WHITE,
    behind,
    filtered,
    names,
    result_of,
    sequence,
)

from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description
from imugap.discovery.search.search import MAX_RESHAPING_GAIN, RESHAPING_SPREAD, Search, behind_filter, may_reach
from imugap.effects import BiasInstability, GaussMarkov, OutputFilter, RandomWalk


@pytest.mark.slow
@pytest.mark.parametrize(("order", "cutoff"), [(1, 0.5), (2, 0.5), (4, 1.5)])
def test_a_step_behind_a_filter_is_one_and_has_its_time_and_size(order, cutoff):
    result = filtered(order, cutoff, np.where(INTERVAL * np.arange(COUNT) >= 431.2, 0.02, 0.0))
    assert names(result) == ["bias_step", "output_filter"]
    step, smooth = sorted(result.findings, key=lambda finding: finding.name)
    assert step.parameters["time"].low <= 431.2 <= step.parameters["time"].high
    assert step.parameters["time"].high - step.parameters["time"].low < 2.0
    assert step.parameters["step"].value == pytest.approx(0.02, rel=0.02)
    assert smooth.parameters["cutoff"].value == pytest.approx(cutoff, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize(("order", "cutoff"), [(1, 2.0), (2, 0.5), (3, 5.0)])
@pytest.mark.parametrize("before", [0.05, 1.0])
def test_a_filter_that_settles_is_a_filter_and_no_more(order, cutoff, before):
    result = filtered(order, cutoff, before=before)
    assert names(result) == ["output_filter"]
    assert not result.withheld
    assert result.findings[0].parameters["cutoff"].value == pytest.approx(cutoff, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("known", [RandomWalk(3e-5), BiasInstability(1e-4), GaussMarkov(3e-4, 20.0)])
@pytest.mark.parametrize("cutoff", [0.6, 3.2])
def test_a_filter_is_found_behind_noise_that_went_far_to_look_like_it(known, cutoff):
    """Without the filter the slow noise of the start model is the whole spectrum, and white noise is none of it."""
    data, hidden = sequence(known), OutputFilter(cutoff, 2)
    result = result_of(behind(data, hidden), start=(WHITE, known))
    assert names(result) == ["output_filter"]
    (found,) = result.findings
    assert found.parameters["cutoff"].low < cutoff < found.parameters["cutoff"].high


@pytest.mark.parametrize("slow", [(), (RandomWalk(3e-5),)])
@pytest.mark.parametrize("cutoff", [0.5, 3.0, 12.0, None])
def test_what_a_filter_gains_is_known_before_it_is_fitted(cutoff, slow):
    data = sequence(*slow, count=6000)
    if cutoff is not None:
        data = behind(data, OutputFilter(cutoff, 2))
    description = Description.known(WHITE, *slow)
    before = fit(data, description)
    search = Search(description, KINDS, LOG_ALPHA)
    for start in OutputFilter.starts(before):
        expected, noise = behind_filter(start, before)
        found = search.trial_of(expected, before, description.with_noise(noise))
        assert found.gain == pytest.approx(expected.gain, abs=RESHAPING_SPREAD)
        likely = replace(expected, gain=expected.gain + MAX_RESHAPING_GAIN)
        assert may_reach(likely, LOG_ALPHA) or found.log_p > LOG_ALPHA


@pytest.mark.parametrize("slow", [(), (GaussMarkov(3e-4, 20.0),), (RandomWalk(3e-5),), (BiasInstability(1e-4),)])
@pytest.mark.parametrize(("cutoff", "shape"), [(0.2, (1, 1)), (0.5, (2, 0)), (3.0, (1, 3)), (12.0, (4, 2))])
def test_the_best_filter_is_as_likely_from_one_of_another_order_as_alone(cutoff, shape, slow):
    data = behind(sequence(*slow, count=6000), OutputFilter(cutoff, *shape))
    before = fit(data, Description.known(WHITE, *slow))
    alone, chained, noise = [], [], None
    for start in OutputFilter.starts(before):
        alone.append(behind_filter(start, before)[0].gain)
        alike = noise is not None and noise.output_filter.form == start.effect.form
        found, noise = behind_filter(start, before, noise if alike else None)
        chained.append(found.gain)
    assert max(chained, default=0.0) > max(alone, default=0.0) - 1.0
