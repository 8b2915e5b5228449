"""Is a name right, or only the nearest one in the catalogue? Each effect is held against its own near misses.

A right description leaves nothing in the directions in which its effects could be slightly something else: a line
that drifts, a trend that bends, a spectrum of another slope, a stretch whose variance is not constant. Where chance
does not explain what is left there, the name is withheld and the place reported as unexplained.
"""

from imugap.discovery.doubt.doubt import LEVEL, Doubt
from imugap.discovery.doubt.doubts import VALUES, beside_a_sweep, doubts
from imugap.discovery.doubt.mean import nearly
from imugap.discovery.doubt.samples import SHARE
from imugap.discovery.doubt.spectrum import OF_NOISE, OF_SLOPE, beside_power_law, share_of

__all__ = ["LEVEL", "OF_NOISE", "OF_SLOPE", "SHARE", "VALUES", "Doubt"]
__all__ += ["beside_a_sweep", "beside_power_law", "doubts", "nearly", "share_of"]
