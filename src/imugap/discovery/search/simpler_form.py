"""Replacement of an effect by its simpler form where the interval of an essential parameter holds zero."""

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.fit.description import Entry
from imugap.discovery.search.intervals import term_intervals
from imugap.discovery.search.search import Candidate, Search


def lost_essential(candidate: Candidate) -> str | None:
    """Return an essential parameter of a term whose interval holds zero, or None."""
    if not candidate.effect.essential:
        return None
    ends = term_intervals(candidate.fit, candidate.index)
    lost = (name for name in candidate.effect.essential if name in ends and ends[name][0] <= 0 <= ends[name][1])
    return next(lost, None)


def simplified(search: Search, found: AxisFit) -> AxisFit:
    """Return the fit with the simpler form of each added effect whose essential parameter may be zero."""
    time = found.sequence.conditions.time
    middle = float(time[0] + time[-1]) / 2
    for one in search.added(found):
        simpler = one.effect.simpler(middle)
        if simpler is not None and lost_essential(one) is not None:
            description = found.description.with_entry(one.index, Entry(simpler.effect, simpler.free))
            return simplified(search, search.fitted(found.sequence, description))
    return found
