"""Words for the views of discovery, shared by figures and pages."""

from collections.abc import Mapping
from typing import NamedTuple


class View(NamedTuple):
    """Title of a view, what lies along its axis, and what it shows."""

    title: str
    along: str
    shows: str

    @property
    def caption(self) -> str:
        """The title and what the view shows, as a sentence."""
        return f"{self.title[0].upper()}{self.title[1:]}: {self.shows}."


VIEWS: Mapping[str, View] = {
    "allan": View("Allan variance", "averaging time", "how the scatter of means changes with the averaging time"),
    "spectrum": View("spectrum", "frequency", "how the power of the error is spread over frequency"),
    "line": View("lines", "frequency", "power at single frequencies, as of vibration or of electronics"),
    "mean": View("mean over time", "time", "drifts and slow changes of the bias"),
    "variance": View("variance over time", "time", "stretches with more or with less noise"),
    "marginal": View(
        "distribution of values", "value in standard deviations", "how often each value occurs, over that of the model"
    ),
    "extremes": View("extremes", "time", "single values that are too large"),
    "change": View("steps of the mean", "time", "sudden changes of the bias"),
    "coherence": View("coherence", "frequency", "noise that two axes share"),
    "temperature": View("mean over temperature", "temperature", "a bias that follows the thermometer"),
    "temperature_rate": View(
        "mean over temperature rate", "temperature rate", "a bias that follows warming and cooling"
    ),
    "rate": View("mean over rate", "rate", "errors of scale and alignment"),
    "specific_force": View(
        "mean over specific force",
        "specific force",
        "errors of scale and alignment, or a gyroscope that senses force",
    ),
    "time_shift": View("mean over the input's derivative", "the input's derivative", "a delay, or a filter"),
    "full_scale": View("mean towards full scale", "mean towards full scale", "values that are clipped"),
    "angular_acceleration": View("mean over angular acceleration", "angular acceleration", "a lever arm"),
    "jerk": View("mean over jerk", "jerk", "an answer to changing force"),
    "rate_product": View("mean over rate products", "rate products", "a lever arm"),
    "force_product": View("mean over force products", "force products", "vibration that is rectified"),
}
"""Views by name, in the order in which pages list them."""


def title(view: str) -> str:
    """Return the title of a view; its name where it has none."""
    return VIEWS[view].title if view in VIEWS else view
