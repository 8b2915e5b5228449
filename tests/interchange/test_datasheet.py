from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from imugap.effects import BiasInstability, GaussMarkov, RandomWalk, TurnOnBias, WhiteNoise
from imugap.effects.gauss_markov import FLAT_TOP
from imugap.interchange.datasheet import MODELS, TRUTHS, DataSheet, Slow

REFERENCE = Path(__file__).parents[1] / "reference/farrell2022_gauss_markov.csv"
PRINTED = pd.read_csv(REFERENCE, comment="#", index_col="quantity")


def test_worked_example_of_the_source():
    sheet = DataSheet(0.0033, PRINTED.value["accel_B"], PRINTED.value["accel_T_B"], 1.4e-4, 0.01)
    found, printed = sheet.gauss_markov().driving_psd, PRINTED.loc["accel_S_B"]
    assert found == pytest.approx(printed["value"], abs=3 * printed["half_digit"])  # B and T_B are printed to 3 digits


@given(st.floats(1e-8, 1e2), st.floats(1e-2, 1e5))
def test_flat_top_of_the_state_is_the_floor_of_the_flicker(flicker, correlation_time):
    process = DataSheet(1.0, flicker, correlation_time, 0.0, 0.0).gauss_markov()
    tau = correlation_time * np.array([1.8, FLAT_TOP, 2.0])
    curve = process.allan_variance(tau)
    assert curve[1] == pytest.approx(BiasInstability(flicker).allan_variance(tau[1]), rel=1e-9)
    assert curve.argmax() == 1


def test_models_hold_what_their_names_say():
    sheet = DataSheet(0.3, 0.1, 60.0, 0.02, 1.0)
    kinds = {"N": WhiteNoise, "B": GaussMarkov, "K": RandomWalk}
    for title, slow in MODELS.items():
        assert {type(effect) for effect in sheet.model(slow)} == {TurnOnBias, *(kinds[s] for s in title.split(" + "))}
    assert BiasInstability(0.1) in sheet.model(TRUTHS["flicker"]).effects
    assert sheet.model(TRUTHS["gauss_markov"]) == sheet.model(MODELS["N + B + K"])


def test_the_order_in_which_processes_are_asked_for_does_not_matter():
    sheet = DataSheet(0.3, 0.1, 60.0, 0.02, 1.0)
    assert sheet.model([Slow.WALK, Slow.GAUSS_MARKOV]) == sheet.model([Slow.GAUSS_MARKOV, Slow.WALK])
