"""Card of a device model: what the model was found on, how surely, what is not known, and how far it is off."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import isclose
from typing import Any

from imugap.effects.effect import Effect
from imugap.model import ErrorModel

SCHEMA = "imugap/device/1"
"""Value of the key ``schema`` of a file with a device model."""
SAME_RATE = 0.01
"""Relative difference of sampling rates that is none."""


def is_card(content: object) -> bool:
    """Return whether the content of a file is a device model with its card."""
    return isinstance(content, Mapping) and content.get("schema") == SCHEMA


@dataclass(frozen=True, eq=False)
class DeviceCard:
    """Device model with its card.

    Attributes
    ----------
    title
        Maker and name of the device.
    model
        Model of the device, without what happened once in the log that it was found on.
    rate_hz
        Sampling rate of that log [Hz].
    content
        All of the file (``workflow/schemas/device_model.schema.yaml``).
    """

    title: str
    model: ErrorModel
    rate_hz: float
    content: Mapping[str, Any]

    @classmethod
    def of(cls, content: Mapping[str, Any], catalogue: Mapping[str, type[Effect]]) -> "DeviceCard":
        """Take the content of a file (:func:`is_card`); ValueError where it is none such."""
        model = ErrorModel.from_mapping(content.get("model"), catalogue)
        try:
            rate = float(content["data"]["logs"][0]["rate_hz"])
            title = " ".join(content["title"].split())
        except (AttributeError, KeyError, IndexError, TypeError, ValueError):
            raise ValueError("card: expected a title, and data with the logs and their rate_hz; found none") from None
        if not model.sensors:
            raise ValueError("card: expected a model of at least one sensor axis; found none")
        return cls(title, model, rate, content)

    def remarks(self, rate: float | None) -> tuple[str, ...]:
        """Return what has to be said of the model at a sampling rate [Hz]."""
        said = [f"model of one {self.title}, found at {self.rate_hz:.4g} Hz (`imugap models` shows its limits)"]
        if rate is not None and rate > self.rate_hz and not isclose(rate, self.rate_hz, rel_tol=SAME_RATE):
            said.append(f"what the device has above {self.rate_hz / 2:.4g} Hz is not known")
        return tuple(said)
