"""Verdicts of the text, all by one rule.

A direction (better, worse, met, missed, nearer, farther, too certain, too careful) is stated only where a 95 % interval
lies wholly on one side of what it is compared with: zero, an aim, one, or the 95 % interval of another value. Else
nothing is decided. A distance is within the floor where it does not exceed the upper end of the floor's 95 % interval.
"""

from collections.abc import Mapping

LEVEL = "no difference beyond chance"
NEARER, FARTHER, NOT_DISTINGUISHED = "nearer", "farther", "not distinguished"
CAREFUL, CONSISTENT, CERTAIN = "too careful", "not distinguished from consistent", "too certain"
UNDECIDED = "not decided"

Interval = tuple[float, float]


def side(interval: Interval, other: float | Interval = 0.0) -> int:
    """Return on which side of another value or interval an interval lies: -1 below, 1 above, 0 where they overlap."""
    low, high = interval
    other_low, other_high = other if isinstance(other, tuple) else (other, other)
    return int(low > other_high) - int(high < other_low)


def difference(interval: Interval, level: str = LEVEL) -> str:
    """Judge the interval of a difference of errors or losses, where smaller is better; ``level`` if it holds zero."""
    return {-1: "better", 0: level, 1: "worse"}[side(interval)]


def aim(interval: Interval, most: float) -> str:
    """Judge the interval of a value that is to be ``most`` at most."""
    return {-1: "met", 0: UNDECIDED, 1: "missed"}[side(interval, most)]


def consistency(interval: Interval) -> str:
    """Judge the interval of a mean NEES per degree of freedom, which is one for a consistent filter."""
    return {-1: CAREFUL, 0: CONSISTENT, 1: CERTAIN}[side(interval, 1.0)]


def gate(interval: Interval, share: float) -> str:
    """Judge the interval of the share of drives in which the gate lowers an error, against its aim and one half.

    The claim fails where the interval lies below its aim; the words after it compare the share with one half.
    """
    if side(interval, share) > 0:
        return "the claim holds"
    if side(interval, share) == 0:
        return "the drives are too few to decide"
    half = {-1: "the gate does harm", 0: "the gate neither helps nor harms beyond chance", 1: "the gate helps"}
    return f"the claim fails, and {half[side(interval, 0.5)]}"


def change(before: Mapping[str, float], after: Mapping[str, float]) -> str:
    """Judge the change of a distance by its intervals before and after, ``low`` to ``high``."""
    apart = side((after["low"], after["high"]), (before["low"], before["high"]))
    return {-1: NEARER, 0: NOT_DISTINGUISHED, 1: FARTHER}[apart]


def distance(before: Mapping[str, float], after: Mapping[str, float], floor: Mapping[str, float]) -> dict:
    """Judge a distance before and after effects were added to the model.

    Parameters
    ----------
    before, after, floor
        ``value``, ``low`` and ``high`` of the distance of the start model, of the final one, and of right models.

    Returns
    -------
    dict
        ``change``; whether the distance was ``within`` the floor, and whether it is now (``reached``); and ``verdict``,
        the words for all three.
    """
    within, reached = (bool(one["value"] <= floor["high"]) for one in (before, after))
    place = {
        (True, True): "within the floor as before",
        (False, True): "within the floor",
        (True, False): "no longer within the floor",
        (False, False): "not within the floor",
    }[within, reached]
    changed = change(before, after)
    return {"change": changed, "within": within, "reached": reached, "verdict": f"{changed}, {place}"}
