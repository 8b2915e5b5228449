"""Where the axes of a device point, and the rotation to the canonical axes: forward, right, down."""

import re

import numpy as np

AS_IS = "as-is"
LETTERS = {
    "F": (0, 1), "N": (0, 1), "B": (0, -1), "S": (0, -1),
    "R": (1, 1), "E": (1, 1), "L": (1, -1), "W": (1, -1),
    "D": (2, 1), "U": (2, -1),
}  # fmt: skip
"""Canonical axis and sign of each direction."""
ALIGNED = 0.9
"""Cosine of the largest angle between gravity and an axis for this axis to be vertical."""
STEADY = 0.9
"""Length of the mean direction of the specific force, 1 for a device that lies one way, below which none is."""
CANONICAL = "FRD"
UPWARD = {(0, 1): "URF", (0, -1): "DRB", (1, 1): "FUR", (1, -1): "FDL", (2, 1): "FLU", (2, -1): CANONICAL}
"""Frame of a device by the axis, and its sign, along which the specific force points: a turn about one axis."""


def rotation_of(frame: str) -> np.ndarray:
    """Return the rotation from the axes of a device to the canonical ones, shape (3, 3).

    Parameters
    ----------
    frame
        Directions of x, y and z (``FLU``, ``FRD``, ``RFU``, ``ENU``, ``NED`` ...), or roll, pitch and heading in
        degrees by which the canonical axes become those of the device.
    """
    letters = frame.strip().upper()
    if re.fullmatch("[FBLRUDNSEW]{3}", letters):
        matrix = np.zeros((3, 3))
        for column, letter in enumerate(letters):
            row, sign = LETTERS[letter]
            matrix[row, column] = sign
        if np.linalg.det(matrix) > 0.5:
            return matrix
        raise ValueError(f"--frame: expected three right-handed directions; found {frame}")
    angles = re.split(r"[,\s]+", frame.strip())
    try:
        roll, pitch, heading = map(float, angles)
    except ValueError:
        expected = "three directions such as FLU, NED or RFU, or roll,pitch,heading in degrees, or as-is"
        raise ValueError(f"--frame: expected {expected}; found {frame!r}") from None
    from imugap.numerics.rotation import from_euler  # takes as long to import as the rest

    return from_euler(np.radians([roll, pitch, heading])).as_matrix()


def upright(direction: np.ndarray) -> str | None:
    """Return the frame of a device with a vertical axis, or None.

    Parameters
    ----------
    direction
        Mean direction of the specific force, shape (3,), shorter than 1 for a device that turns.
    """
    length = float(np.linalg.norm(direction))
    axis = int(np.argmax(np.abs(direction)))
    if length < STEADY or abs(direction[axis]) < ALIGNED * length:
        return None
    return UPWARD[axis, 1 if direction[axis] > 0 else -1]


def vertical(frame: str) -> str:
    """Return which axis of a frame of :data:`UPWARD` is vertical, in words."""
    axis, sign = next(place for place, name in UPWARD.items() if name == frame)
    return f"{'xyz'[axis]} {'up' if sign > 0 else 'down'}"


def own_axes(frame: str) -> tuple[str, str, str] | None:
    """Return which axis of a file each canonical one is, such as ``("x", "-y", "-z")`` of FLU.

    None where they are the same, and where a frame is turned by other angles than right ones.
    """
    if frame == AS_IS or frame.strip().upper() == CANONICAL:
        return None
    rotation = rotation_of(frame)
    if not np.isin(rotation, (-1.0, 0.0, 1.0)).all():
        return None
    x, y, z = (f"{'-' if row.sum() < 0 else ''}{'xyz'[int(np.argmax(np.abs(row)))]}" for row in rotation)
    return x, y, z


def axes_text(frame: str) -> str:
    """Return how the canonical axes follow from those of a file, in words; nothing where they are the same."""
    if frame == AS_IS or frame.strip().upper() == CANONICAL:
        return ""
    own, said = own_axes(frame), "x forward, y right, z down"
    if own is None:
        return f"{said}; those of the log are turned ({frame})"
    if [one[-1] for one in own] == [*"xyz"]:
        return f"{said}; {' and '.join(one[-1] for one in own if len(one) > 1)} of the log are reversed"
    return f"{said}, which are {', '.join(own)} of the log"
