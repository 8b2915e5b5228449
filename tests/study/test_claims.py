import pandas as pd
import pytest

from imugap.study.claims import of_walk, reliability
from imugap.study.static.rankings import share_interval


@pytest.mark.parametrize(
    ("shares", "tables", "verdict"),
    [
        ((1.0, 1.0, 1.0), 40, "reliable"),
        ((1.0, 1.0, 1.0), 4, "not decided"),
        ((0.80, 0.92, 1.0), 40, "likely, not shown to be reliable"),
        ((0.56, 0.94, 0.97), 40, "not decided"),
        ((0.36, 0.27, 0.72), 40, "not decided"),
        ((0.30, 0.27, 0.20), 40, "unlikely"),
    ],
)
def test_shares_of_tables_are_judged_by_their_intervals(shares, tables, verdict):
    assert reliability([share_interval(share, tables) for share in shares]) == verdict


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
