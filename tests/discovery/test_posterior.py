"""Posterior probabilities of the explanations of a place: laws, bounds, and the words for them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from imugap.discovery.finding import Finding
from imugap.discovery.posterior import NONE, OTHER, UNKNOWN, ambiguity_set, percent, posterior
from imugap.discovery.verdict import certainty
from imugap.effects import RateRamp

LOG_PS = st.floats(-1000.0, 0.0) | st.just(-np.inf)
RIVALS = st.dictionaries(st.sampled_from(["sinusoid", "warm_up", "rate_ramp"]), st.floats(-50.0, 20.0))


@given(log_p=LOG_PS, misfit_log_p=LOG_PS, rivals=RIVALS)
def test_probabilities_of_all_explanations_add_up_to_one(log_p, misfit_log_p, rivals):
    found = posterior("temperature", log_p, misfit_log_p, rivals.items(), 180)
    assert {"temperature", NONE, OTHER, UNKNOWN, *rivals} == set(found)
    assert sum(found.values()) == pytest.approx(1.0)
    assert list(found.values()) == sorted(found.values(), reverse=True)


@given(log_p=LOG_PS, misfit_log_p=st.floats(-1000.0, -2.0), rivals=RIVALS)
def test_a_worse_fit_of_its_shape_takes_probability_from_the_name(log_p, misfit_log_p, rivals):
    some, less = (
        posterior("temperature", log_p, one, rivals.items(), 180)["temperature"]
        for one in (misfit_log_p, 1.1 * misfit_log_p)
    )
    assert less <= some * (1 + 1e-12)


def test_names_that_explain_a_place_alike_are_alike_probable():
    found = posterior("rate_ramp", -40.0, 0.0, [("warm_up", 0.0)], 180)
    assert found["warm_up"] == pytest.approx(found["rate_ramp"])
    assert set(ambiguity_set(found)) >= {"warm_up", "rate_ramp"}


def test_a_name_that_passes_every_test_by_a_wide_margin_stands_alone():
    assert ambiguity_set(posterior("sinusoid", -200.0, -0.5, [("gauss_markov", -30.0)], 180)) == ("sinusoid",)


@pytest.mark.parametrize("width", [0.5, 1.0, 2.0, 4.0, 10.0])
@pytest.mark.parametrize("p_value", [1e-6, 1e-4, 1e-2])
def test_nothing_is_never_less_probable_than_with_any_normal_prior_of_the_size(width, p_value):
    """The least Bayes factor of a p-value is below that of a normally distributed effect of any width."""
    z = norm.isf(p_value / 2)
    exact = norm.pdf(z) / norm.pdf(z, scale=np.hypot(1, width))
    found = posterior("bias_step", np.log(p_value), 0.0, (), 1)
    assert found[NONE] / found["bias_step"] <= exact * (1 + 1e-9)


@given(shares=st.lists(st.floats(0.001, 1.0), min_size=1, max_size=8), level=st.floats(0.5, 0.99))
def test_no_smaller_set_of_explanations_has_the_level(shares, level):
    probabilities = {f"name_{number}": share / sum(shares) for number, share in enumerate(shares)}
    chosen = ambiguity_set(probabilities, level)
    largest = sorted(probabilities.values(), reverse=True)
    assert sum(probabilities[name] for name in chosen) >= level - 1e-9
    assert sum(largest[: len(chosen) - 1]) < level


def test_a_probability_near_an_end_is_said_as_a_bound():
    assert [percent(share) for share in (0.0001, 0.314, 0.9999)] == ["below 1 %", "31 %", "above 99 %"]


def test_the_verdict_says_what_is_likely_beside_the_name_and_which_names_remain():
    shares = {"rate_ramp": 0.6, "temperature": 0.3, UNKNOWN: 0.07, OTHER: 0.02, NONE: 0.01}
    finding = Finding({"gyro_x": RateRamp(1e-6)}, {}, -40.0, alternatives=(("warm_up", -1.0),), probabilities=shares)
    assert certainty(finding) == (
        "probability of the name 60 %, of an effect that has no name 7 %; "
        "the log cannot tell it from warm-up, temperature"
    )
