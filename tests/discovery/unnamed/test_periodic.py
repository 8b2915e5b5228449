import pytest
from tests.discovery.simulated import beside_white, fitted

from imugap.discovery.unnamed import periodic


@pytest.mark.parametrize("count", [19_997, 20_011])
@pytest.mark.parametrize("periods", [5.3, 41.7, 93.1])
def test_the_search_reaches_the_gain_at_the_true_frequency(count, periods):
    """Also for lengths of the log that no fast transform divides."""
    frequency = periods / (0.05 * count)
    data = beside_white(lambda time, rng: 2e-3 * (time * frequency % 1), count)
    found = fitted(data)
    own = periodic.gain_at(frequency, found)
    assert own > 50
    assert 0.95 * own < periodic.gain(found) < 1.02 * own + 5
