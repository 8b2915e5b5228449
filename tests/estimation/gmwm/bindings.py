"""Bind kinds of effects to the wavelet variances of a sequence of 5000 samples."""

from imugap.estimation.gmwm.implied import Binding
from imugap.estimation.likelihood import Composition

INTERVAL = 0.1


def binding(*kinds, width=2, levels=12):
    return Binding(Composition.of(*kinds), INTERVAL, 5000, levels, width)
