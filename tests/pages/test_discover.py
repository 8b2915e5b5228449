"""Page of a discovery: an effect that several axes share has one section, with the digits that its intervals need."""

import re

from imugap.discovery.finding import Finding, Interval
from imugap.effects import Sinusoid
from imugap.pages.discover import _missing
from imugap.pages.page import DataTable


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
