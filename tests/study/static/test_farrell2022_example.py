from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from imugap.effects import BiasInstability, GaussMarkov
from imugap.numerics.spectra import allan_from_psd as spectrum
from imugap.study.static.farrell2022_example import Agreement, Check, PrintedExample, checks, flat_top, floor_gain

PRINTED = pd.read_csv(Path(__file__).parents[3] / "data/published/farrell2022_worked_example.csv")
REFERENCE = pd.read_csv(Path(__file__).parents[2] / "reference/farrell2022_gauss_markov.csv", comment="#", index_col=0)


@pytest.fixture(scope="module")
def found():
    return {check.quantity: check for check in checks(PRINTED)}


def test_printed_values_are_those_that_the_tests_restate():
    kept = PRINTED.set_index(["sensor", "quantity"])["value"]
    restated = {"accel": "accelerometer", "gyro_a": "gyroscope a", "gyro_b": "gyroscope b"}
    for short, sensor in restated.items():
        for quantity in ("floor", "B"):
            assert REFERENCE.loc[f"{short}_{quantity}", "value"] == kept[sensor, quantity]
    for quantity in ("floor_tau", "T_B", "S_B"):
        assert REFERENCE.loc[f"accel_{quantity}", "value"] == kept["accelerometer", quantity]


def test_flat_top_and_floor_are_those_of_the_integrated_spectra():
    place, height = flat_top()
    tau = place * np.array([0.98, 1.0, 1.02])
    below, top, above = np.sqrt(spectrum.allan_variance(GaussMarkov(2**-0.5, 1.0).psd, tau))  # S_B = T_B = 1
    assert top == pytest.approx(height, rel=1e-7)
    assert max(below, above) < top
    assert np.sqrt(spectrum.allan_variance(BiasInstability(1.0).psd, 7.0)) == pytest.approx(floor_gain(), rel=1e-7)


def test_arithmetic_of_the_example_holds_and_its_physics_does_not(found):
    verdicts = {name: check.agreement for name, check in found.items()}
    arithmetic = [name for name in verdicts if "over 0.664" in name and "leave" not in name]
    assert len(arithmetic) == 3
    assert all(verdicts[name] == Agreement.AGREES for name in arithmetic)
    assert verdicts["S_B: flat top at the floor (eq. 37)"] == Agreement.WITHIN_DIGITS
    assert verdicts["floor: N and K alone at its place (eq. 30)"] == Agreement.WITHIN_DIGITS
    for name in ("place of the floor: that of N and K, √3 N/K", "B: what N and K leave of the floor, over 0.664",
                 "floor: N, K and the B that was read on it, together"):  # fmt: skip
        assert verdicts[name] == Agreement.CONTRADICTS


def test_white_noise_and_walk_alone_exceed_the_printed_floor(found):
    """methods.md section 2; the number is that of the brief: sqrt(N^2/60 + K^2 60/3) = 7.57e-4."""
    assert found["floor: N and K alone at its place (eq. 30)"].recomputed == pytest.approx(7.57e-4, abs=5e-7)


def test_most_that_is_left_is_found_at_the_corner_of_the_digits(found):
    example = PrintedExample.of(PRINTED)
    corner = np.sqrt(7.45e-4**2 - 0.00325**2 / 59.5 - 0.000135**2 * 59.5 / 3)
    assert example.most_left() == pytest.approx(corner, rel=1e-9)
    assert found["B: what N and K leave of the floor, over 0.664"].high == pytest.approx(corner / 0.66428, rel=1e-4)


def test_freed_model_reaches_the_upper_end_of_the_printed_floor_and_the_model_as_read_lies_far_above():
    example = PrintedExample.of(PRINTED)
    (tau,), ((_, highest),) = example("accelerometer", "floor_tau"), example.ranges("accelerometer", "floor")
    assert np.sqrt(example.freed().allan_variance(tau)) == pytest.approx(highest, rel=2e-3)
    assert np.sqrt(example.model().allan_variance(tau)) > 1.4 * highest


def test_digits_of_white_noise_and_walk_hold_their_sum():
    example, tau = PrintedExample.of(PRINTED), np.geomspace(1, 100, 9)
    digits, sum_of_both = example.digits(tau), np.sqrt(example.white_and_walk().allan_variance(tau))
    assert np.all((digits["low"] < sum_of_both) & (sum_of_both < digits["high"]))


@pytest.mark.parametrize(
    ("recomputed", "low", "high", "expected"),
    [
        (1.04, 1.04, 1.04, Agreement.AGREES),
        (1.06, 1.02, 1.09, Agreement.WITHIN_DIGITS),
        (1.1, 1.06, 1.2, Agreement.CONTRADICTS),
        (0.9, 0.8, 0.94, Agreement.CONTRADICTS),
        (0.9, 0.8, 0.96, Agreement.WITHIN_DIGITS),
    ],
)
def test_agreement_is_that_of_the_ranges(recomputed, low, high, expected):
    assert Check("any", 1.0, 0.05, "1", recomputed, low, high).agreement == expected
