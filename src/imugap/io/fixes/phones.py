"""Positions of a phone: the file Location.csv in the folder or archive of its sensors."""

from dataclasses import replace
from pathlib import Path

from imugap.io.fixes import tables
from imugap.io.fixes.decoded import Decoded
from imugap.io.fixes.receiver_settings import ReceiverSettings
from imugap.io.formats import sensor_files
from imugap.log import LogError

LOCATION = "location.csv"


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a path is a folder or an archive with a file for each sensor."""
    return sensor_files.recognises(path, head)


def decode(path: Path, settings: ReceiverSettings) -> Decoded:
    """Return the positions; LogError where there is no file of them."""
    with sensor_files.files(path) as found:
        place = next((found[name] for name in found if name.lower() == LOCATION), None)
        if place is None:
            raise LogError(path, "files", "Location.csv with the positions", ", ".join(found)[:200] or "none")
        return tables.decode(place, replace(settings, topic=None))
