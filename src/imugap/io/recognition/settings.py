"""What a user says of a recording."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class RecordingSettings:
    """What the user says of a recording; anything not given is recognised from the file.

    Attributes
    ----------
    columns
        A name for each column of the file from left to right, or ``canonical=name in the file``, or those to read
        (:func:`imugap.io.recognition.column_names.chosen`).
    units
        Unit of each quantity, ``gyro``, ``accel`` or ``temperature``
        (:func:`imugap.io.recognition.units.given_units`).
    frame
        Where the axes of the device point (:func:`imugap.io.recognition.frame.rotation_of`); ``as-is`` turns nothing.
    rate_hz
        Sampling rate, where the file has no stamps [Hz].
    time_unit
        Unit of the stamps.
    topic
        Topic of a bag, or message of a log, that holds the samples.
    rows
        Of how many devices the rows alternate, and which is read: ``(1, 2)`` takes the first of each two rows; ``(1,
        1)`` takes all as of one device (:func:`given_rows`).
    """

    columns: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    frame: str | None = None
    rate_hz: float | None = None
    time_unit: str | None = None
    topic: str | None = None
    rows: tuple[int, int] | None = None


def given_rows(text: str) -> tuple[int, int]:
    """Return which row of how many is read from ``1/2``; ValueError where it is none."""
    number, _, devices = text.partition("/")
    if not (number.isdecimal() and devices.isdecimal() and 1 <= int(number) <= int(devices)):
        raise ValueError(f"--rows: expected one row of some, such as 1/2; found {text!r}")
    return int(number), int(devices)


DEFAULTS = RecordingSettings()
