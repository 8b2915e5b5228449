"""Page of a drive: whether device and fixes agree, the path from above, sensor errors, and quality of the fixes."""

from collections.abc import Mapping

from imugap.analysis.drive import COUNTED, NavigatedDrive
from imugap.figures import drive
from imugap.figures.style import CARD
from imugap.log import AXES
from imugap.pages.page import DataTable, Gallery, Page, Part, Picture, Points, Text
from imugap.workflow.tables import number

OVER_TIME = {
    "speed": "Speed of the vehicle, and the standard deviation of the horizontal velocity.",
    "height": "Height above the ellipsoid, and the standard deviation of the horizontal position.",
    "heading": "Heading, and its standard deviation.",
}
EXTENT = {
    "duration_s": "duration [s]", "distance_m": "distance [m]", "fixes": "fixes", "outages": "outages",
    "longest_outage_s": "longest outage [s]", "end_horizontal_std_m": "σ of the position at the end [m]",
    "end_heading_std_deg": "σ of the heading at the end [°]",
}  # fmt: skip
CONSISTENCY = (
    "The normalised innovation squared (NIS) is the mean square of what the fixes say beyond the prediction, over what "
    "the filter states: 1 if the filter knows its errors."
)


def page(found: NavigatedDrive) -> Page:
    """Compose the page of a drive."""
    summary, verdict = found.summary(), found.verdict
    corrected = tuple(f"{one.found}: {one.setting}." for one in verdict.corrections)
    counts = DataTable("Events.", ("event", "number"), events(summary))
    return Page(
        "Where did the vehicle go, and do device and receiver agree?",
        (*str(verdict).splitlines(), _extent(found, summary)),
        verdict.agrees,
        (
            Part("What to write into the configuration", (Text(CORRECTIONS), Points(corrected)) if corrected else ()),
            Part("Path", (Gallery((_track(found),)), Text(MAPS), DataTable("Extent.", ("", "value"), extent(summary)))),
            Part("Over time", (_over_time(found),)),
            Part("Errors of the sensors", (Text(ERRORS), _sensors(found), _settings(summary), Text(GIVEN))),
            Part(
                "Quality of the fixes",
                (
                    Text(CONSISTENCY),
                    Points((f"NIS {consistency(summary)}.",)),
                    _quality(found),
                    counts if counts.rows else Text("Every fix was taken as it is."),
                ),
            ),
        ),
    )


def extent(summary: Mapping) -> tuple[tuple[str, str], ...]:
    """Return title and value of each number of the extent."""
    return tuple((title, f"{summary[key]:.4g}") for key, title in EXTENT.items())


def events(summary: Mapping) -> tuple[tuple[str, str], ...]:
    """Return name and number of the events of the quality control that happened."""
    counts = {name: summary[name.replace(" ", "_")] for name in COUNTED}
    return tuple((name, str(count)) for name, count in counts.items() if count)


def consistency(summary: Mapping) -> str:
    """Return the NIS and what is usual."""
    nis, low, high = (number(summary[name]) for name in ("nis", "nis_low", "nis_high"))
    return f"{nis}; 95 % of consistent filters lie in {low} to {high}"


CORRECTIONS = "Each contradiction of device and fixes was corrected; with the setting beside it, it does not arise."
MAPS = (
    "path.geojson (WGS-84, heights above the ellipsoid) and path.kml (on the ground) beside this page open in maps and "
    "geographic information systems."
)
ERRORS = (
    "What the filter takes off the sensors, with one standard deviation. An error that stays within its band around "
    "zero is one that the drive does not show."
)
GIVEN = (
    "The time offset is added to the stamps of the fixes. A setting with – is used as given, and corrected only where "
    "it contradicts the drive; in the configuration, lever_arm: {std_m: 2} and time_offset: {std_s: 0.3} have them "
    "estimated, which takes turns and changes of speed."
)


def _extent(found: NavigatedDrive, summary: dict) -> str:
    """Return in words how long the drive is, and where in the log it starts."""
    before = summary["start_s"] - found.inputs.log.index[0]
    return (
        f"The drive is {summary['distance_m']:.5g} m and {summary['duration_s']:.4g} s long. It starts {before:.3g} s "
        "into the log, at the first fix that gives the course."
    )


def _track(found: NavigatedDrive) -> Picture:
    figure = drive.track(found.filtered, found.smoothed, found.fixes, CARD)
    sentence = (
        "The drive from above. The filter knows the past only, the smoother all fixes; crosses are fixes that were not "
        "taken as they are."
    )
    return Picture(figure, sentence, "Path of the vehicle from above, east over north, with the fixes")


def _over_time(found: NavigatedDrive) -> Gallery:
    return Gallery(
        tuple(
            Picture(drive.over_time(found.filtered, found.smoothed, name), sentence, f"Curves of the {name} over time")
            for name, sentence in OVER_TIME.items()
        )
    )


def _sensors(found: NavigatedDrive) -> Gallery:
    return Gallery(
        tuple(
            Picture(
                drive.sensor(found.filtered, found.smoothed, axis),
                f"Error of {axis}.",
                f"Curves of the error of {axis} over time, by filter and smoother",
            )
            for axis in AXES
            if axis in found.filtered.names
        )
    )


def _settings(summary: dict) -> DataTable:
    """Return the settings in use that the drive itself shows."""
    offset, arm = summary["time_offset_s"], summary["lever_arm_m"]
    named = {"time offset [s]": offset} | {f"lever arm {axis} [m]": one for axis, one in arm.items()}
    rows = [
        (title, f"{one['value']:.3g}", f"{one['std']:.2g}" if one["std"] > 0 else "–") for title, one in named.items()
    ]
    return DataTable("Settings of the device in the vehicle, as estimated at the end.", ("", "value", "σ"), tuple(rows))


def _quality(found: NavigatedDrive) -> Gallery:
    sentence = (
        "Global test of each fix. It fails above the dotted line, as one in many fixes of a good receiver does. "
        "Single components are weighed down or removed by a test of their own; quality.svg beside this page has it."
    )
    return Gallery((Picture(drive.global_test(found.filtered), sentence, "Statistic of the global test over time"),))
