"""Correction of a drive: what was wrong with device or receiver, in words, and what was done about it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Correction:
    """Correction of the inputs of a drive.

    Attributes
    ----------
    error
        Short name of the error.
    found
        What was found, in words.
    setting
        What was done: the setting of the configuration that does the same, or what was left out.
    explains
        Whether device and fixes may agree with it; a correction that only bears a contradiction does not.
    """

    error: str
    found: str
    setting: str
    explains: bool = True

    def __str__(self) -> str:
        """Return both in one line."""
        return f"{self.found} ({self.setting})"
