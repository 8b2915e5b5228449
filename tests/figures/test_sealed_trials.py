import numpy as np
import pandas as pd

from imugap.figures.sealed_trials import losses


def test_half_sizes_beyond_the_axis_are_triangles_at_its_edges():
    curve = pd.DataFrame({"size": [1.0, 2.0, 4.0], "rate": [0.2, 0.5, 0.9]}).assign(low=0.1, high=0.95)
    table = pd.DataFrame({"name": ["white_noise", "sinusoid", "dead_zone"], "half": [0.2, 1.5, np.inf]})
    figure = losses(curve, table.assign(low=0.1, high=9.0), 200)
    marks = {line.get_marker(): list(line.get_ydata()) for line in figure.axes[1].lines}
    assert (marks["<"], marks["o"], marks[">"]) == ([0], [1], [2])
