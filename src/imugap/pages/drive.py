"""Page of a drive: whether device and fixes agree, the path from above, sensor errors, and quality of the fixes."""

from collections.abc import Mapping

import numpy as np

from imugap.analysis.drive import COUNTED, NavigatedDrive
from imugap.figures import drive
from imugap.figures.style import CARD
from imugap.log import AXES
from imugap.pages.model import parameter_table
from imugap.pages.page import Block, DataTable, Gallery, Page, Part, Picture, Points, Snippet, Text
from imugap.workflow.tables import number

OVER_TIME = {
    "speed": "Speed of the vehicle, and the standard deviation of the horizontal velocity.",
    "height": "Height above the ellipsoid, and the standard deviation of the horizontal position.",
    "heading": "Heading, and its standard deviation.",
}
EXTENT = {"duration_s": "duration [s]", "distance_m": "distance [m]", "fixes": "fixes"}
CONSISTENCY = (
    "The normalised innovation squared (NIS) is the mean square of what the fixes say beyond the prediction, over what "
    "the filter states: 1 if the filter knows its errors."
)


def page(found: NavigatedDrive) -> Page:
    """Compose the page of a drive."""
    summary, verdict = found.summary(), found.verdict
    counts = DataTable("Events.", ("event", "number"), events(summary))
    return Page(
        "Where did the vehicle go, and do device and receiver agree?",
        (*str(verdict).splitlines(), _extent(found, summary)),
        verdict.agrees,
        (
            Part("What to write into the configuration", (Text(SETTINGS), Snippet(found.settings.text("model.yaml")))),
            Part("Path", (Gallery((_track(found),)), Text(MAPS), DataTable("Extent.", ("", "value"), extent(summary)))),
            Part("Drift without fixes", _drift(found)),
            Part("Over time", (_over_time(found),)),
            Part("Errors of the sensors", (Text(ERRORS), _sensors(found), _settings(summary), Text(GIVEN))),
            Part("Noise in use", _noise(found, summary)),
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
    """Return title and value of each row of the extent."""
    longest = f", the longest {summary['longest_outage_s']:.4g} s" if summary["outages"] else ""
    ends = f"{summary['end_horizontal_std_m']:.4g} m horizontally, {summary['end_heading_std_deg']:.4g}° of heading"
    return (
        *((title, f"{summary[key]:.4g}") for key, title in EXTENT.items()),
        ("outages", f"{summary['outages']}{longest}"), ("σ at the end", ends),
    )  # fmt: skip


def events(summary: Mapping) -> tuple[tuple[str, str], ...]:
    """Return name and number of the events of the quality control that happened."""
    counts = {name: summary[name.replace(" ", "_")] for name in COUNTED}
    return tuple((name, str(count)) for name, count in counts.items() if count)


def consistency(summary: Mapping) -> str:
    """Return the NIS and what is usual."""
    nis, low, high = (number(summary[name]) for name in ("nis", "nis_low", "nis_high"))
    return f"{nis}; 95 % of consistent filters lie in {low} to {high}"


SETTINGS = (
    "All settings in use that are not the default, in full. The file settings.yaml beside this page has them: "
    "--config settings.yaml gives the same result, with what was left out of the fixes left out again."
)
DRIFT = (
    "The fixes within each window were withheld. The filter predicts from the begin of the window to its end, where "
    "the fix shows how far it drifted horizontally. The ratio compares the drift with what it states: for 95 % of "
    "consistent filters it lies in its band. Above the band the drift is larger than stated, below it smaller. All "
    "numbers include the noise of the fixes."
)
NO_ROOM = "The drive is too short for a window without fixes."
NOISE = (
    "What the filter assumed of the device. A factor that the drive has shown, as by vibration, is in these numbers. "
    "The file model.yaml beside this page has them in SI for a filter of your own. Other tools (kalibr, ros, vins ...) "
    "take them in conventions of their own:"
)
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


def drift_text(summary: Mapping) -> tuple[str, str]:
    """Return title and words on the drift over outages: median and 95th percentile, and what is stated."""
    rows = summary["drift_over_outages"]
    parts = [
        f"{one['median_m']:.3g} (95 %: {one['p95_m']:.3g}) in {one['length_s']:g} s, {_windows(one['windows'])}, "
        f"{_against(one)}"
        for one in rows
    ]
    return "drift without fixes [m]", "; ".join(parts) or "no room for a window"


def _windows(count: int) -> str:
    return f"{count} window{'s' if count > 1 else ''}"


def _against(one: Mapping) -> str:
    """Return how a drift compares with the stated one, in words."""
    within = one["ratio_low"] <= one["ratio"] <= one["ratio_high"]
    return "as stated" if within else f"{one['ratio']:.2g} times the stated"


def _drift(found: NavigatedDrive) -> tuple[Block, ...]:
    """Return the table of the drift over outages."""
    rows = tuple(
        (
            f"{one.length_s:g} s", str(one.windows), f"{one.median_m:.3g}",
            f"{one.p95_m:.3g}", f"{one.rms_m:.3g}",
            f"{one.stated_rms_m:.3g}", f"{one.ratio:.2f}", f"{one.ratio_low:.2f} to {one.ratio_high:.2f}",
        )
        for one in found.outages.drifts.itertuples()
    )  # fmt: skip
    titles = ("without fixes", "windows", "median [m]", "95 % [m]", "RMS [m]", "stated RMS [m]", "ratio", "its band")
    return (Text(DRIFT), DataTable("Horizontal drift.", titles, rows)) if rows else (Text(NO_ROOM),)


def _noise(found: NavigatedDrive, summary: Mapping) -> tuple[Block, ...]:
    """Return the noise of device and receiver in use."""
    rate = 1 / float(np.median(np.diff(found.inputs.log.index)))
    command = Snippet(f"imugap export model.yaml --to kf-gins --rate {rate:.4g} --out kf-gins.yaml")
    return parameter_table(found.settings.model), Text(NOISE), command, _receiver(summary)


def _receiver(summary: Mapping) -> DataTable:
    """Return the noise of the receiver in use."""
    slow, names = summary["receiver_slow_std"], {"north": "m", "east": "m", "down": "m"}
    rows = [
        (
            f"{name.replace('_', ' ')} [{names.get(name, 'm/s')}]",
            number(std),
            number(slow[name]) if slow.get(name) else "–",
        )
        for name, std in summary["receiver_std"].items()
    ]
    over = f" over {summary['receiver_slow_s']:.3g} s" if any(slow.values()) else ""
    titles = ("", "σ from fix to fix", f"σ of slow errors{over}")
    return DataTable("Noise of the receiver, median over the fixes.", titles, tuple(rows))


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
