import subprocess
import sys

import numpy as np
import pytest
from scipy.stats import chi2

from imugap.numerics.samples.chi_square import log_tail, squared_radius


@pytest.mark.parametrize(("value", "freedom"), [(0.0, 1), (1.0, 1), (30.0, 2), (900.0, 3)])
def test_the_tail_is_that_of_the_law(value, freedom):
    assert log_tail(value, freedom) == pytest.approx(chi2.logsf(value, freedom), rel=1e-12)


def test_a_tail_that_underflows_is_minus_infinity_without_a_warning():
    assert log_tail(5000.0, 1) == -np.inf


def test_effects_and_filters_load_no_statistics():
    """Each process of the command line and of the workflow would pay for it."""
    code = "import sys, imugap.analysis.drive, imugap.analysis.walk; assert 'scipy.stats' not in sys.modules"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


@pytest.mark.parametrize("probability", [0.0, 0.5, 0.9, 0.99, 1 - 1e-9])
def test_the_squared_radius_is_the_quantile_with_two_degrees_of_freedom(probability):
    assert squared_radius(probability) == pytest.approx(chi2.ppf(probability, 2), rel=1e-7, abs=1e-15)
