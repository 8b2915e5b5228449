import numpy as np
import pandas as pd
import pytest

from imugap.effects import WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation.result import Fit, ParameterEstimate
from imugap.stream import stream
from imugap.study.static.monte_carlo import row, summary, worse_than

KEY = ("white_noise", 1, "density")


def repeated(values, width):
    """One estimate per run, with an interval of the given half width."""
    fits = [
        Fit(
            AxisModel((WhiteNoise(1.0),)),
            (ParameterEstimate(*KEY, v, v - width, v + width, 0.1, "identified"),),
            0.0,
            True,
        )
        for v in values
    ]
    return pd.concat([row(fit, method="own", run=run) for run, fit in enumerate(fits)])


def of(values, width, true=2.0, bound=0.05):
    index = pd.MultiIndex.from_tuples([KEY])
    return summary(repeated(values, width), pd.Series([true], index), pd.Series([bound], index), seed=1).iloc[0]


def test_bias_error_and_coverage_of_known_values():
    found = of([1.8, 2.0, 2.2, 2.4], 0.25)
    assert found["bias"] == pytest.approx(0.05)
    assert found["rmse"] == pytest.approx(np.sqrt((0.1**2 + 0 + 0.1**2 + 0.2**2) / 4))
    assert found["efficiency"] == pytest.approx(found["rmse"] / 0.05)
    assert found["coverage"] == 0.75
    assert found["coverage_low"] < 0.75 < found["coverage_high"]
    assert found["rmse_low"] < found["rmse"] < found["rmse_high"]


def test_a_failed_run_counts_as_not_covered_and_is_left_out_of_the_error():
    found = of([2.0, np.nan], 0.1)
    assert (found["failed"], found["coverage"], found["rmse"]) == (1, 0.5, 0.0)


@pytest.mark.slow
def test_intervals_of_the_summary_hold_the_truth_as_often_as_they_say():
    """Unit normal errors: root mean square 1 (relative to 2: 0.5), coverage of one standard deviation 68.27 %."""
    held = np.zeros(2)
    for k in range(200):
        found = of(2 + stream(3, k).standard_normal(60), 1.0)
        held += [
            found["rmse_low"] <= 0.5 <= found["rmse_high"],
            found["coverage_low"] <= 0.6827 <= found["coverage_high"],
        ]
    assert (abs(held / 200 - 0.95) < [0.06, 0.05]).all()


def test_a_method_is_worse_only_where_its_interval_lies_above():
    ends = {"allan": (2.3, 3.3), "indirect": (0.7, 2.2), "likelihood": (0.5, 0.9)}
    rows = [
        {"effect": "white_noise", "parameter": "density", "time": 10, "method": method,
         "efficiency_low": low, "efficiency_high": high}
        for method, (low, high) in ends.items()
    ]  # fmt: skip
    summaries = pd.DataFrame(rows + [{**one, "time": 50, "efficiency_low": 0.4} for one in rows])
    assert list(worse_than(summaries, "likelihood")) == [("white_noise", "density", 10, ["allan"])]
