import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from imugap.numerics.samples.runs import runs_of


@pytest.mark.parametrize(
    ("mask", "runs"),
    [([], []), ([0, 0], []), ([1, 1], [[0, 2]]), ([1, 0, 1, 1, 0], [[0, 1], [2, 4]]), ([0, 1], [[1, 2]])],
)
def test_a_run_has_its_first_value_and_its_end(mask, runs):
    assert runs_of(np.array(mask, bool)).tolist() == runs


@given(st.lists(st.booleans()))
def test_runs_make_the_mask_again_and_do_not_touch(mask):
    again = np.zeros(len(mask), bool)
    runs = runs_of(np.array(mask, bool))
    for first, end in runs:
        again[first:end] = True
    assert again.tolist() == mask
    assert (runs[1:, 0] > runs[:-1, 1]).all()
