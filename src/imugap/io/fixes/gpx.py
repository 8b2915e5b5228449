"""Tracks of GPX: points with time; the heights are those of the file, mostly above sea level."""

from datetime import datetime
from pathlib import Path
from xml.etree import ElementTree

import pandas as pd

from imugap.io.fixes.decoded import Decoded
from imugap.io.fixes.receiver_settings import ReceiverSettings
from imugap.log import TIME, LogError


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file begins as GPX."""
    return b"<gpx" in head


def decode(path: Path, settings: ReceiverSettings) -> Decoded:
    """Return the points of all tracks; LogError where one has no time or height."""
    rows = []
    for _, element in ElementTree.iterparse(path):
        if element.tag.rpartition("}")[2] == "trkpt":
            inner = {child.tag.rpartition("}")[2]: child.text for child in element}
            absent = [name for name in ("time", "ele") if not inner.get(name)]
            if absent:
                raise LogError(path, f"point {len(rows)}", "a time and a height (ele)", f"no {absent[0]}")
            time = datetime.fromisoformat(inner["time"].strip()).timestamp()
            rows.append((time, float(element.get("lat")), float(element.get("lon")), float(inner["ele"])))
            element.clear()
    table = pd.DataFrame(rows, columns=[TIME, "latitude", "longitude", "height"]).set_index(TIME)
    return Decoded(table, ("GPX, UTC in seconds since 1970, heights as in the file",))
