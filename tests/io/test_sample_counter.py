"""A counter of samples beside ``--rate`` shows which samples are lost."""

import numpy as np
import pandas as pd
import pytest
from tests.io.devices import at_rest, write_text

from imugap.io.recording import RecordingSettings, read, stream
from imugap.io.sample_counter import numbers
from imugap.log import AXES

COUNT, LOST = 3000, 100
KEPT = np.sort(np.random.default_rng(3).choice(COUNT - 2, COUNT - 2 - LOST, replace=False)) + 1
KEPT = np.r_[0, KEPT, COUNT - 1]
RATE = RecordingSettings(rate_hz=50.0)


@pytest.mark.parametrize("width", [100, 256, 65536])
@pytest.mark.parametrize("name", ["seq", "packet_counter", "sample"])
def test_samples_that_a_counter_lacks_are_gaps_and_that_is_said(tmp_path, name, width):
    table = at_rest(COUNT, up=(0, 0, -1))
    path = write_text(tmp_path / "run.csv", [name, *AXES], np.column_stack([KEPT % width, table[KEPT]]))
    found = read(path, RATE)
    assert f"samples counted by {name} at 50 Hz from the option, {LOST} lost" in found.recognised
    assert not any("left out" in one for one in found.recognised)
    np.testing.assert_allclose(found.regular.log.to_numpy()[KEPT], table[KEPT], rtol=1e-6, atol=1e-9)
    assert np.count_nonzero(found.regular.lost) == LOST
    parts = pd.concat(list(stream(path, RATE)[1]))
    np.testing.assert_allclose(parts.index, KEPT / 50)


@pytest.mark.parametrize("first", [0, 250])
def test_a_counter_without_losses_numbers_the_rows(first):
    np.testing.assert_array_equal(numbers((first + np.arange(1000.0)) % 256), np.arange(1000))


@pytest.mark.parametrize(
    "values", [np.repeat(np.arange(500.0), 2), np.arange(1000.0) * 20, np.arange(1000) / 50, np.full(1000, 3.0)]
)
def test_what_does_not_count_rows_is_no_counter(values):
    assert numbers(values) is None
