from types import SimpleNamespace

import pytest

from imugap.discovery.finding import Discrepancy, Unnamed
from imugap.discovery.verdict import agrees, describe_locations, nothing_named, unnamed_sentences


def place(axis, view, low, high, unit="Hz"):
    return Discrepancy(view, axis, low, high, unit, 1e-9)


def test_places_of_one_axis_and_view_are_one_range_with_their_number():
    places = [place("gyro_x", "line", 3.0, 3.1), place("gyro_y", "line", 5.0, 5.0), place("gyro_x", "line", 1.0, 1.2)]
    assert describe_locations(places) == "gyro_x, line, 1 to 3.1 Hz (2 places); gyro_y, line, 5 Hz"


def test_a_place_that_occurs_twice_is_one():
    assert describe_locations([place("gyro_x", "line", 5.0, 5.0)] * 2) == "gyro_x, line, 5 Hz"


def test_many_places_stay_one_sentence_that_names_how_many_more_there_are():
    places = [place("gyro_x", f"view {number}", number, number) for number in range(195)]
    text = describe_locations(places)
    assert text.startswith("gyro_x, view 0, 0 Hz; ")
    assert text.endswith("; and 183 more views, all of them in the table of places")
    assert len(text) < 400


def test_what_is_not_named_for_one_reason_is_one_sentence_for_each_axis():
    def of(axis, name, reason):
        return Unnamed(axis, name, reason, {})

    found = [
        of("gyro_x", "variance_change", "they come at a beat"),
        of("gyro_x", "chirp", "its spectrum has another shape"),
        of("gyro_x", "variance_change", "they come at a beat"),
        of("gyro_y", "chirp", "its spectrum has another shape"),
        of("gyro_x", "scale_factor", "its spectrum has another shape"),
        of("gyro_y", "gauss_markov", "its spectrum has another shape"),
    ]
    assert list(unnamed_sentences(found)) == [
        "gyro_x: something like variance change (2), but they come at a beat; not named.",
        "gyro_x: something like chirp, scale factor, but its spectrum has another shape; not named.",
        "gyro_y: something like chirp, Gauss-Markov, but its spectrum has another shape; not named.",
    ]


NOTHING = {"findings": (), "withheld": (), "unexplained": (), "shapes": ()}


def test_nothing_is_missing_only_where_the_log_shows_nothing():
    nothing = SimpleNamespace(**NOTHING)
    assert agrees(nothing)
    assert nothing_named(nothing).startswith("Nothing is missing")


@pytest.mark.parametrize("kind", ["withheld", "unexplained", "shapes"])
def test_what_is_seen_without_a_name_is_a_disagreement(kind):
    found = SimpleNamespace(**NOTHING | {kind: ("seen",)})
    assert not agrees(found)
    assert "disagrees" in nothing_named(found)
    assert "has a name" in nothing_named(found)


def test_a_name_is_a_disagreement():
    assert not agrees(SimpleNamespace(**NOTHING | {"findings": ("named",)}))
