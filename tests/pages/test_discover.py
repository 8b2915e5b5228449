"""Page of a discovery: an effect that several axes share has one section, with the digits that its intervals need."""

import re

from imugap.discovery.finding import Finding, Interval
from imugap.effects import Sinusoid, Temperature
from imugap.pages.discover import _missing
from imugap.pages.page import DataTable, Points, Text


def sinusoid(axis, frequency, name="sinusoid"):
    spread = 2e-5
    parameters = {"frequency": Interval(frequency, frequency - spread, frequency + spread, "Hz")}
    effect = Sinusoid(frequency, 1e-3, 0.0)
    return Finding({axis: effect}, parameters, -40.0, probabilities={name: 0.98})


def test_one_section_for_an_effect_that_axes_share():
    found = [
        sinusoid("gyro_x", 6.99998),
        sinusoid("gyro_y", 7.0),
        sinusoid("gyro_x", 11.0),
        sinusoid("gyro_z", 7.00001),
    ]
    topics = list(_missing(found))
    assert [one.title for one in topics] == ["Sinusoid on gyro_x, gyro_y, gyro_z", "Sinusoid on gyro_x"]
    (table,) = (block for block in topics[0].blocks if isinstance(block, DataTable))
    assert table.rows[0] == ("gyro_x", "frequency", "6.999980", "6.999960 to 7.000000", "Hz")
    assert len(table.rows) == 3
    (own,) = (block for block in topics[1].blocks if isinstance(block, DataTable))
    assert own.titles[0] == "parameter"
    assert all(re.fullmatch(r"11\.000000|10\.999980 to 11\.000020|Hz|frequency", cell) for cell in own.rows[0])


def temperature(axis, probability):
    parameters = {
        "coefficient": Interval(1e-4, 0.9e-4, 1.1e-4, "rad/s/degC"),
        "reference": Interval(30.2, 30.2, 30.2, "degC"),
        "quadratic": Interval(0.0, 0.0, 0.0, "rad/s/degC^2"),
    }
    return Finding({axis: Temperature(1e-4, 30.2)}, parameters, -40.0, probabilities={"temperature": probability})


def test_axes_stand_in_order_and_terms_that_an_effect_does_not_have_are_left_out():
    (topic,) = _missing([temperature("gyro_z", 0.98), temperature("gyro_x", 0.98)])
    assert topic.title == "Temperature on gyro_x, gyro_z"
    (table,) = (block for block in topic.blocks if isinstance(block, DataTable))
    assert [row[1] for row in table.rows] == ["coefficient", "reference"] * 2
    assert table.rows[1][2:4] == ("30.2", "–")


def test_one_sentence_for_axes_whose_name_is_as_probable():
    (alike,) = _missing([temperature("gyro_x", 0.98), temperature("gyro_y", 0.98)])
    assert Text("Probability of the name 98 %.") in alike.blocks
    axes = [temperature("gyro_x", 0.98), temperature("gyro_y", 0.9), temperature("gyro_z", 0.98)]
    (topic,) = _missing(axes)
    (points,) = (block for block in topic.blocks if isinstance(block, Points))
    assert points.items[0] == "gyro_x, gyro_z: probability of the name 98 %."
