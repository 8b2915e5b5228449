"""Detect chirps in the whitened residual of a fit (:mod:`imugap.numerics.spectra.stack_slide`)."""

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.unnamed.wandering_lines import Band
from imugap.numerics.spectra.stack_slide import highest_track


def find_chirps(found: AxisFit, log_alpha: float) -> tuple[Band, ...]:
    """Return the band [Hz] of the strongest chirp in the whitened residual of a fit, none if not significant."""
    track = highest_track(found.whitened)
    if track is None or track.log_p > log_alpha:
        return ()
    low, high = (end / found.sequence.conditions.interval for end in track.ends)
    return (Band(low, high, track.log_p),)
