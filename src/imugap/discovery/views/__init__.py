"""Views of a fit: vectors of statistics that show where data and model differ.

Each maps an :class:`imugap.discovery.fit.axis_fit.AxisFit`, or two, to a :class:`Curve` over a location.
"""

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.views.conditional import Binning, binnings, of_conditions
from imugap.discovery.views.curve import Curve
from imugap.discovery.views.marginal import of_marginal
from imugap.discovery.views.spectral import COHERENCE, of_allan, of_coherence, of_line, of_spectrum, shared_last
from imugap.discovery.views.temporal import of_change, of_extremes, of_mean, of_variance

VIEWS = (of_allan, of_spectrum, of_line, of_mean, of_variance, of_marginal, of_extremes, of_change)
"""Views of one axis that need only its fit."""

__all__ = ["COHERENCE", "VIEWS", "Binning", "Curve", "binnings", "curves", "of_coherence", "shared_last"]


def curves(fit: AxisFit, over: tuple[Binning, ...] = ()) -> dict[tuple[str, str], Curve]:
    """Return all views of a fit, by name and axis of the input (empty for none)."""
    found = {(view.view, ""): view for view in (make(fit) for make in VIEWS)}
    if over:
        found |= {(item.view, item.source): curve for item, curve in zip(over, of_conditions(fit, over), strict=True)}
    return found
