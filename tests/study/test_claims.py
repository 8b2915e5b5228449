import pandas as pd
import pytest

from imugap.study.claims import of_walk, reliability


@pytest.mark.parametrize(
    ("shares", "verdict"),
    [
        ((0.95, 1.0, 0.97), "reliable"),
        ((0.80, 0.92, 1.0), "likely, not reliable"),
        ((0.50, 0.99, 1.0), "depends on the draw"),
        ((0.36, 0.27, 0.72), "depends on the draw"),
        ((0.36, 0.27, 0.40), "unlikely"),
    ],
)
def test_shares_of_tables_are_judged_by_their_ends(shares, verdict):
    assert reliability(pd.Series(shares)) == verdict


@pytest.mark.parametrize(
    ("position", "heading", "verdict"),
    [
        ((-2.0, -3.0, -1.0), (-1.0, -2.0, -0.5), "holds"),
        ((-2.0, -3.0, -1.0), (-1.0, -2.0, 0.5), "not decided"),
        ((1.6, 0.1, 3.3), (1.2, -0.4, 3.0), "does harm"),
        ((0.2, -0.1, 0.3), (0.2, -0.4, 0.5), "not decided"),
    ],
)
def test_a_walk_is_judged_by_both_intervals_and_harm_is_called_harm(position, heading, verdict):
    values = {f"{name}_excess{end}": value for name, ends in (("position", position), ("heading", heading))
              for end, value in zip(("", "_low", "_high"), ends, strict=True)}  # fmt: skip
    printed = pd.DataFrame({"restoration": {"end_position_error_reduction": 35.3, "end_heading_error_reduction": 31.2}})
    assert of_walk(pd.DataFrame([{"contender": "restoration", **values}]), printed)["verdict"] == verdict
