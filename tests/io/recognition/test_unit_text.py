import pytest

from imugap.io.recognition.unit_text import QUANTITIES, quantity_of, unit_of

SPELLINGS = {
    "rad/s": "rad/s|rad s^-1|radians/sec|rad_s|rad·s⁻¹|RAD/S",
    "deg/s": "deg/s|°/s|dps|deg per second|degrees/s|deg s-1|deg_per_s",
    "mdeg/s": "mdps|mdeg/s",
    "m/s^2": "m/s^2|m/s²|m s^-2|m/s/s|m/(s^2)|m_s2|m/s2|meters per s^2",
    "g": "g|G|gs",
    "mg": "mg",
    "ft/s^2": "ft/s^2|ft/s/s",
    "ns": "ns|nanoseconds|nsec",
    "us": "us|µs|usec|microseconds",
    "ms": "ms|msec|milliseconds",
    "s": "s|sec|seconds",
    "degC": "°C|degC|celsius",
    "m/s": "m/s",
    "rad": "rad",
}


@pytest.mark.parametrize("unit", SPELLINGS)
def test_every_spelling_is_its_unit(unit):
    assert {unit_of(text) for text in SPELLINGS[unit].split("|")} == {unit}


@pytest.mark.parametrize("text", ["", "uT", "no units", "m", "1/s", "g s", "rad/s^2", "V", "%", "m^2/s"])
def test_what_is_no_unit_of_a_log_is_none(text):
    assert unit_of(text) is None


def test_a_unit_is_of_one_quantity():
    units = [unit for known in QUANTITIES.values() for unit in known]
    assert len(units) == len(set(units))
    assert all(quantity_of(unit) == quantity for quantity, known in QUANTITIES.items() for unit in known)
