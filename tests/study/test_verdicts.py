import pytest

from imugap.study import verdicts

ENDS = ("value", "low", "high")


@pytest.mark.parametrize(
    ("interval", "other", "side"),
    [
        ((-2.0, -0.1), 0.0, -1),
        ((-2.0, 0.1), 0.0, 0),
        ((0.1, 2.0), 0.0, 1),
        ((0.0, 0.0), 0.0, 0),
        ((1.0, 1.2), 1.3, -1),
        ((3.0, 4.0), (1.0, 2.0), 1),
        ((3.0, 4.0), (1.0, 3.0), 0),
    ],
)
def test_an_interval_is_on_a_side_only_where_it_lies_there_wholly(interval, other, side):
    assert verdicts.side(interval, other) == side


def test_words_follow_the_side():
    intervals = ((-2.0, -1.0), (-1.0, 1.0), (1.0, 2.0))
    assert [verdicts.difference(one) for one in intervals] == ["better", "no difference beyond chance", "worse"]
    aims = ((1.0, 1.2), (1.2, 1.4), (1.4, 2.0))
    assert [verdicts.aim(one, 1.3) for one in aims] == ["met", "not decided", "missed"]


@pytest.mark.parametrize(
    ("interval", "said"),
    [
        ((0.96, 1.0), "the claim holds"),
        ((0.90, 0.97), "the drives are too few to decide"),
        ((0.60, 0.80), "the claim fails, and the gate helps"),
        ((0.40, 0.60), "the claim fails, and the gate neither helps nor harms beyond chance"),
        ((0.10, 0.40), "the claim fails, and the gate does harm"),
    ],
)
def test_the_gate_is_judged_by_its_aim_and_by_one_half(interval, said):
    assert verdicts.gate(interval, 0.95) == said


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ((9.0, 8.0, 10.0), (2.0, 1.5, 3.0), "nearer"),
        ((9.0, 8.0, 10.0), (7.0, 6.0, 8.0), "not distinguished"),
        ((2.0, 1.0, 3.0), (2.5, 1.5, 3.5), "not distinguished"),
        ((2.0, 1.0, 3.0), (5.0, 3.5, 6.0), "farther"),
    ],
)
def test_a_change_is_told_only_where_the_intervals_do_not_overlap(before, after, said):
    before, after = (dict(zip(ENDS, one, strict=True)) for one in (before, after))
    assert verdicts.change(before, after) == said


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ((9.0, 8.0, 10.0), (1.0, 0.9, 1.1), "nearer, within the floor"),
        ((9.0, 8.0, 10.0), (3.0, 2.0, 4.0), "nearer, not within the floor"),
        ((1.0, 0.9, 1.1), (1.05, 0.9, 1.2), "not distinguished, within the floor as before"),
        ((1.0, 0.9, 1.1), (3.0, 2.0, 4.0), "farther, no longer within the floor"),
    ],
)
def test_a_distance_is_also_judged_against_the_floor(before, after, said):
    floor = {"value": 1.0, "low": 0.8, "high": 1.25}
    found = verdicts.distance(*(dict(zip(ENDS, one, strict=True)) for one in (before, after)), floor)
    assert found["verdict"] == said
    assert said.startswith(found["change"])


@pytest.mark.parametrize(
    ("interval", "said"),
    [((1.2, 3.0), "too certain"), ((0.6, 1.4), "not distinguished from consistent"), ((0.02, 0.9), "too careful")],
)
def test_a_filter_is_called_too_certain_or_too_careful_only_where_its_interval_leaves_out_one(interval, said):
    assert verdicts.consistency(interval) == said
