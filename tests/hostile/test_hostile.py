"""Mutated inputs of every command end in a result or in one line: no traceback, no warning, nothing left behind.

A case is known by its command and number. Cases that fail are named; ``faults(CASES[command](stream(SEED, command,
number)), folder)`` repeats one.
"""

import pytest
from tests.hostile.harness import CASES, catalogue_faults, faults

from imugap.stream import stream

SEED = 7
USUAL = {
    "check": 60, "formats": 40, "indices": 60, "simulate": 60, "export": 100, "estimate": 25, "discover": 8, "walk": 2,
    "drive": 5, "convert": 40, "models": 10, "reference": 20,
}  # fmt: skip
"""Number of cases of each command in the usual tests; those that reach a long computation are few."""
ALL = {
    "check": 1400, "formats": 1600, "indices": 1200, "simulate": 1200, "export": 1600, "estimate": 300, "discover": 30,
    "walk": 10, "drive": 30, "convert": 1000, "models": 80, "reference": 600,
}  # fmt: skip
"""The same in the slow tests: 10 000 with the catalogues."""


def failed(command, numbers, folder):
    found = {number: faults(CASES[command](stream(SEED, command, number)), folder) for number in numbers}
    return {number: wrong for number, wrong in found.items() if wrong}


@pytest.mark.parametrize("command", CASES)
def test_a_mutated_input_ends_in_a_result_or_in_one_line(tmp_path, command):
    assert failed(command, range(USUAL[command]), tmp_path / "work") == {}


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("command", CASES)
def test_many_mutated_inputs_end_in_a_result_or_in_one_line(tmp_path, command):
    assert failed(command, range(USUAL[command], ALL[command]), tmp_path / "work") == {}


@pytest.mark.parametrize("count", [60, pytest.param(1000, marks=pytest.mark.slow)])
def test_a_mutated_catalogue_is_read_or_refused_and_stays_in_its_folder(tmp_path, count):
    found = {number: catalogue_faults(number, tmp_path / "work") for number in range(count)}
    assert {number: wrong for number, wrong in found.items() if wrong} == {}
