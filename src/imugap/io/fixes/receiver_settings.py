"""What a user says of the fixes of a receiver."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ReceiverSettings:
    """What the user says of fixes; anything not given is recognised from the file.

    Attributes
    ----------
    topic
        Topic of a bag, message of a log, or group of columns.
    angles
        Unit of latitude and longitude, ``deg`` or ``rad``.
    """

    topic: str | None = None
    angles: str | None = None


DEFAULTS = ReceiverSettings()
