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
    """

    columns: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    frame: str | None = None
    rate_hz: float | None = None
    time_unit: str | None = None
    topic: str | None = None


DEFAULTS = RecordingSettings()
