"""Baseline that identifies the power law of the noise by its lag-1 autocorrelation (Riley and Greenhall 2004).

The function is ``autocorr_noise_id`` of allantools. It is asked at the averaging times from one sample to the longest
that it takes, octave by octave; each answer that the start model does not have is named.
"""

import allantools

from imu_benchmark.baselines.findings import answer, effect
from imu_benchmark.case import Case

NAMES = {2: "quantization", 0: "white_noise", -1: "bias_instability", -2: "random_walk"}
"""Names of the exponents of the spectral density; flicker of phase (1) has none."""
FEWEST = 30
"""Fewest averages that allantools asks for."""


def report(case: Case) -> dict:
    """Return the power laws that the start model does not have."""
    return answer(
        effect(name, [axis])
        for axis in case.axes
        for name in _laws(case.errors(axis), 1 / case.interval)
        if name not in case.known(axis)
    )


def _laws(values, rate: float) -> list[str]:
    found, size = [], 1
    while len(values) // size >= FEWEST:
        try:
            exponent = allantools.autocorr_noise_id(values, size, data_type="freq")[0]
        except (NotImplementedError, ValueError):
            break
        found.append(NAMES.get(int(exponent)))
        size *= 2
    return list(dict.fromkeys(name for name in found if name))
