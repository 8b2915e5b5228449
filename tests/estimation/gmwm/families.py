"""Bind kinds of effects to the wavelet variances of a sequence of 5000 samples."""

from imugap.estimation.gmwm.implied import Family
from imugap.estimation.likelihood import Composition

INTERVAL = 0.1


def family_of(*kinds, width=2, levels=12):
    return Family(Composition.of(*kinds), INTERVAL, 5000, levels, width)
