import pytest

from imugap.study.distances import change


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
    ends = ("value", "low", "high")
    assert change(dict(zip(ends, before, strict=True)), dict(zip(ends, after, strict=True))) == said
