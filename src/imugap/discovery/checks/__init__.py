"""Goodness-of-fit tests of the effects that a search adds: is each of the named form, or only close to it?

Each effect is tested against small departures from its form (a line that drifts, a trend that bends, a spectrum of
another slope, a variance that is not constant) by score tests, and against alternatives that are not in the catalogue
by likelihood ratios. Where the misfit is significant, the name is withheld and its location is reported as
unexplained. May import unnamed, search, views, fit and preparation.
"""

from imugap.discovery.checks.all_checks import MIN_EXTRA_VALUES, explained_by_bands, misfits, tested
from imugap.discovery.checks.gaussianity import MIN_SHARE
from imugap.discovery.checks.mean import shape_log_p
from imugap.discovery.checks.misfit import MAX_LOG_P, Misfit
from imugap.discovery.checks.spectrum import NOISE_REASONS, SLOPE_REASONS, add_power_law, power_share

__all__ = ["MAX_LOG_P", "MIN_EXTRA_VALUES", "MIN_SHARE", "NOISE_REASONS", "SLOPE_REASONS", "Misfit"]
__all__ += ["add_power_law", "explained_by_bands", "misfits", "power_share", "shape_log_p", "tested"]
