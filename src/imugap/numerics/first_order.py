"""First-order recursion, compiled."""

from numba import njit


@njit(cache=True)
def recurse(decay, noise, before=0.0):
    """Return z_k = decay z_(k-1) + noise_k, shape of ``noise``; z_(-1) is ``before``."""
    result = noise.copy()
    for k in range(len(noise)):
        result[k] += decay * before
        before = result[k]
    return result
