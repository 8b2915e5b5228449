"""Rows that are out of order are read in the order of their stamps where these leave no doubt."""

import numpy as np
import pytest
from tests.io.devices import at_rest, times, write_text

from imugap.io.recording import read
from imugap.io.rows import by_stamps
from imugap.log import AXES, LogError

COUNT = 3000


def swapped(count):
    order = np.arange(count)
    for first in range(7, count - 1, 40):
        order[[first, first + 1]] = order[[first + 1, first]]
    return order


ORDERS = {
    "from the last to the first": np.arange(COUNT)[::-1],
    "out of order": np.random.default_rng(5).permutation(COUNT),
    "rows out of order: sorted by their stamps": swapped(COUNT),
}


@pytest.mark.parametrize("said", ORDERS)
def test_rows_are_read_in_the_order_of_their_stamps(tmp_path, said):
    table = np.column_stack([times(COUNT), at_rest(COUNT, up=(0, 0, -1))])
    found = read(write_text(tmp_path / "run.csv", ["time", *AXES], table[ORDERS[said]]))
    np.testing.assert_allclose(found.log.to_numpy(), table[:, 1:], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(found.log.index, table[:, 0])
    assert not found.regular.remarks
    assert sum(said in one for one in found.recognised) == 1
    assert found.place(10) == f"line {np.flatnonzero(ORDERS[said] == 10)[0] + 2}"


@pytest.mark.parametrize(
    "stamps",
    [
        np.arange(COUNT) * 20.0,  # in order
        np.arange(COUNT) * 20 % 65536,  # a counter that wraps
        np.r_[np.arange(COUNT // 2), np.arange(COUNT // 2)] * 20.0,  # another run
        np.r_[np.arange(COUNT // 2) * 20.0, np.arange(COUNT // 2) * 20.0 + 10],  # another run, between the stamps
        np.arange(COUNT) * 20.0 + np.random.default_rng(6).normal(0, 12, COUNT),  # stamps on arrival
        np.full(COUNT, 7.0),
        np.r_[1e300, np.arange(COUNT) * 1e-12],  # a stamp beyond any clock
        np.full(COUNT, np.inf),
    ],
)
def test_rows_that_stamps_do_not_show_to_be_out_of_order_stay(stamps):
    assert by_stamps(stamps) is None


def test_stamps_that_are_all_equal_are_refused_with_the_next_step(tmp_path):
    table = np.column_stack([np.full(COUNT, 1.7e12), at_rest(COUNT)])
    with pytest.raises(LogError, match=r"--rate HZ.*found 1.7e\+12 in all 3000 rows"):
        read(write_text(tmp_path / "run.csv", ["timestamp", *AXES], table))
