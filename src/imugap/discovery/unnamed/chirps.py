"""Lines whose frequency sweeps: too thin at every frequency and at every time, but not along their own track."""

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.unnamed.wandering_lines import Band
from imugap.numerics.stack_slide import highest_track


def swept(found: AxisFit, log_alpha: float) -> tuple[Band, ...]:
    """Return the band of the line that sweeps through the residual of a fit, if chance does not explain it."""
    track = highest_track(found.whitened)
    if track is None or track.log_p > log_alpha:
        return ()
    low, high = (end / found.sequence.conditions.interval for end in track.ends)
    return (Band(low, high, track.log_p),)
