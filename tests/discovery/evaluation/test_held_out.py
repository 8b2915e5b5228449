"""Further runs of a device beside the models of the first one."""

import numpy as np
import pytest

from imugap import log
from imugap.discovery.evaluation import held_out as comparison
from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description, Entry
from imugap.discovery.preparation.prepare import prepare
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.effects import Bias, BiasStep, ClockScale, TurnOnBias, VarianceChange, WhiteNoise
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel
from imugap.model import ErrorModel

COUNT, INTERVAL = 6000, 0.1
WHITE, STEP, CHANGE = WhiteNoise(1e-3), BiasStep(200.0, 2e-3), VarianceChange(300.0, 400.0, 2.0)


def run(*effects, label):
    """Return a log of one axis at rest."""
    ideal = log.from_samples({"gyro_x": np.zeros(COUNT)}, INTERVAL)
    return ErrorModel({"gyro_x": AxisModel((WHITE, *effects))}).simulate(ideal, 1, label)


def found(table, *events):
    """Return what a fit says of a log in which events are known."""
    conditions = Conditions(table.index.to_numpy(), INTERVAL, axis="gyro_x")
    sequence = AxisSequence(table["gyro_x"].to_numpy(), conditions)
    terms = tuple(Entry(one, ("step",)) for one in events if isinstance(one, BiasStep))
    changes = tuple(one for one in events if isinstance(one, VarianceChange))
    return fit(sequence, Description.known(WHITE).adding(*terms, *changes))


def modelled(description):
    return ErrorModel({"gyro_x": AxisModel((Bias(0.0), *description.effects()))})


@pytest.mark.parametrize("again", [(), (STEP,), (CHANGE,), (STEP, CHANGE)])
def test_what_happened_in_one_run_is_in_the_model_of_another_in_which_it_happens_again(again):
    first = run(STEP, CHANGE, label="first")
    bare, whole = found(first), found(first, STEP, CHANGE)
    fits = {"gyro_x": bare}, {"gyro_x": whole}
    start, final = modelled(bare.description), modelled(whole.description)
    after = comparison.compare_test_run(prepare(run(*again, label="other")), *fits, start, final).after.model["gyro_x"]
    kept = {one.name for one in after if isinstance(one, (BiasStep, VarianceChange))}
    assert kept == {one.name for one in again}


def test_a_model_of_one_run_has_neither_what_differs_between_runs_nor_a_clock():
    sensor, clock = AxisModel((Bias(0.1), TurnOnBias(0.2), WHITE)), AxisModel((ClockScale(0.01),))
    kept = comparison.of_one_run(ErrorModel({"gyro_x": sensor, "time": clock}))
    assert list(kept.axes) == ["gyro_x"]
    assert {effect.name for effect in kept["gyro_x"]} == {"bias", "white_noise"}
