import numpy as np
import pytest

from imugap.integrity.precision import grain


@pytest.mark.filterwarnings("error")
def test_numbers_next_to_zero_count_as_zero():
    """A power of ten below theirs is no number."""
    values = np.round(np.linspace(0.1, 1.0, 50), 3)
    np.testing.assert_array_equal(grain(np.r_[values, 4.9e-320])[:-1], grain(np.r_[values, 0.0])[:-1])
