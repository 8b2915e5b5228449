"""Changes of a distance between a log and the simulations of a model."""

NEARER, FARTHER, NOT_DISTINGUISHED = "nearer", "farther", "not distinguished"


def change(before: dict[str, float], after: dict[str, float]) -> str:
    """Judge a change of a distance: nearer or farther only where the 95 % intervals do not overlap.

    Parameters
    ----------
    before, after
        ``value``, ``low`` and ``high`` of the distance, of the start model and of the final one.
    """
    if after["high"] < before["low"]:
        return NEARER
    return FARTHER if after["low"] > before["high"] else NOT_DISTINGUISHED
