import pytest
from tests.discovery.simulated import KINDS, KNOWN, LOG_ALPHA, fitted, sequence

from imugap.discovery.checks.mean import mean_misfit
from imugap.discovery.fit.description import Entry
from imugap.discovery.search.search import Candidate, Search
from imugap.effects import Chirp, Sinusoid
from imugap.effects.chirp import CHIRP


def judged(hidden, tried):
    """The misfit of a chirp that is fitted to an effect from the given values on."""
    fit = fitted(sequence(hidden), Entry(tried, CHIRP))
    return mean_misfit(Candidate(Search(KNOWN, KINDS, LOG_ALPHA), fit, len(fit.description.terms) - 1))


def test_a_line_that_does_not_move_is_no_chirp():
    found = judged(Sinusoid(0.9, 1e-3, 0.4), Chirp(0.9, 1e-8, 1e-3, 0.4))
    assert found.reason == "the log does not tell its chirp rate"


@pytest.mark.parametrize("rate", [1e-4, -1e-4])
def test_a_chirp_that_moves_keeps_its_name(rate):
    chirp = Chirp(0.9, rate, 1e-3, 0.4)
    assert judged(chirp, chirp).log_p > -5


def test_a_drift_of_two_periods_is_no_chirp():
    drift = Chirp(1e-3, 1e-6, 1e-3, 0.4)
    assert "fewer than 3 periods" in judged(drift, drift).reason
