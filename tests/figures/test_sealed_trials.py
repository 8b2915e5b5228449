import numpy as np
import pandas as pd
import pytest

from imugap.figures.sealed_trials import losses, reliability


def test_half_sizes_beyond_the_axis_are_triangles_at_its_edges():
    curve = pd.DataFrame({"size": [1.0, 2.0, 4.0], "rate": [0.2, 0.5, 0.9]}).assign(low=0.1, high=0.95)
    table = pd.DataFrame({"name": ["white_noise", "sinusoid", "dead_zone"], "half": [0.2, 1.5, np.inf]})
    figure = losses(curve, table.assign(low=0.1, high=9.0), 200)
    marks = {line.get_marker(): list(line.get_ydata()) for line in figure.axes[1].lines}
    assert (marks["<"], marks["o"], marks[">"]) == ([0], [1], [2])


def test_bins_of_nearly_one_probability_stand_apart():
    bins = pd.DataFrame({"bin": [4, 5], "confidence": [0.499, 0.501], "count": [1, 90], "rate": [0.0, 0.46]})
    panel = reliability(bins.assign(low=0.0, high=[0.98, 0.57])).axes[0]
    assert [label.get_text() for label in panel.get_xticklabels()] == ["40 to 50 %\n(1)", "50 to 60 %\n(90)"]
    assert np.diff(panel.get_xticks()) == 1


@pytest.mark.parametrize("half", [[1.0, 2.0], [0.1, 2.0], [1.0, 99.0], [0.1, 99.0]])
def test_the_panels_of_the_losses_fill_the_figure(half):
    share = np.array([0.1, 0.5, 0.9])
    curve = pd.DataFrame({"size": [1.0, 2.2, 4.7], "rate": share, "low": share - 0.1, "high": share + 0.1})
    table = pd.DataFrame({"name": ["sinusoid", "warm_up"], "half": half, "low": half, "high": half})
    figure = losses(curve, table, 240)
    figure.draw_without_rendering()
    assert all(panel.get_position().width > 0.3 for panel in figure.axes)
