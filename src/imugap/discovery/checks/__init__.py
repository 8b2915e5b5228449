"""Is a name right, or only the nearest one in the catalogue? Each effect is held against its own near misses.

A right description leaves nothing in the directions in which its effects could be slightly something else: a line
that drifts, a trend that bends, a spectrum of another slope, a stretch whose variance is not constant. Where chance
does not explain what is left there, the name is withheld and the place reported as unexplained.
"""

from imugap.discovery.checks.all_checks import VALUES, beside_a_sweep, doubts
from imugap.discovery.checks.gaussianity import SHARE
from imugap.discovery.checks.mean import nearly
from imugap.discovery.checks.misfit import LEVEL, Doubt
from imugap.discovery.checks.spectrum import OF_NOISE, OF_SLOPE, beside_power_law, share_of

__all__ = ["LEVEL", "OF_NOISE", "OF_SLOPE", "SHARE", "VALUES", "Doubt"]
__all__ += ["beside_a_sweep", "beside_power_law", "doubts", "nearly", "share_of"]
