import numpy as np
import pytest
from tests.discovery.simulated import KINDS, KNOWN, LOG_ALPHA, fitted, sequence

from imugap.discovery.fit.description import Entry
from imugap.discovery.search.search import Search
from imugap.discovery.search.simpler_form import simplified
from imugap.effects import Chirp, Sinusoid
from imugap.effects.chirp import CHIRP

SEARCH = Search(KNOWN, KINDS, LOG_ALPHA)


def test_a_chirp_that_does_not_move_becomes_the_line():
    line = Sinusoid(0.9, 1e-3, 0.4)
    found = simplified(SEARCH, fitted(sequence(line), Entry(Chirp(0.9, 1e-8, 1e-3, 0.4), CHIRP)))
    (effect,) = (one for one in found.description.effects() if one.tonal)
    assert isinstance(effect, Sinusoid)
    assert effect.frequency == pytest.approx(line.frequency, abs=1e-4)
    assert effect.amplitude == pytest.approx(line.amplitude, rel=0.1)


def test_a_chirp_that_moves_stays():
    chirp = Chirp(0.9, 1e-4, 1e-3, 0.4)
    found = fitted(sequence(chirp), Entry(chirp, CHIRP))
    assert simplified(SEARCH, found) is found


@pytest.mark.parametrize("rate", [1e-7, -1e-7])
def test_the_line_is_the_chirp_at_its_time(rate):
    chirp, time = Chirp(0.9, rate, 1.0, 0.4), 300.0
    near = time + np.linspace(-1, 1, 9)
    line = chirp.simpler(time).effect
    np.testing.assert_allclose(
        np.cos(2 * np.pi * line.frequency * near + line.phase), np.cos(chirp.angle(near)), atol=1e-6
    )
