"""Path of a vehicle as GeoJSON and KML, for maps and geographic information systems."""

from collections.abc import Sequence
from xml.etree import ElementTree

import numpy as np
import pandas as pd

from imugap.navigation.drive.vehicle import DriveSolution

MOST = 5000
"""Largest number of points: more than a map shows."""
DECIMALS = 7
"""Digits of an angle in degrees, a centimetre."""
KML = "http://www.opengis.net/kml/2.2"


def geojson(solution: DriveSolution) -> dict:
    """Return the path as a GeoJSON feature collection: a line, and the points of begin and end (RFC 7946).

    Longitude and latitude [deg], height above the WGS-84 ellipsoid [m]; ``time`` [s] is that of the log.
    """
    places, time = _places(solution)
    line = {"type": "LineString", "coordinates": places}
    features = [_feature(line, {"name": "path", "begin_s": time[0], "end_s": time[-1]})]
    for name, at in (("begin", 0), ("end", -1)):
        features.append(_feature({"type": "Point", "coordinates": places[at]}, {"name": name, "time_s": time[at]}))
    return {"type": "FeatureCollection", "features": features}


def kml(solution: DriveSolution) -> str:
    """Return the path as KML, on the ground: KML counts heights from the sea level, the path from the ellipsoid."""
    places, _ = _places(solution)
    root = ElementTree.Element("kml", xmlns=KML)
    document = ElementTree.SubElement(root, "Document")
    path = _placemark(document, "path")
    line = ElementTree.SubElement(path, "LineString")
    ElementTree.SubElement(line, "tessellate").text = "1"
    ElementTree.SubElement(line, "coordinates").text = " ".join(map(_pair, places))
    for name, place in (("begin", places[0]), ("end", places[-1])):
        point = ElementTree.SubElement(_placemark(document, name), "Point")
        ElementTree.SubElement(point, "coordinates").text = _pair(place)
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _places(solution: DriveSolution) -> tuple[list[list[float]], list[float]]:
    """Return longitude, latitude [deg] and height [m] of points spread over the path, both ends included, and times."""
    table: pd.DataFrame = solution.geodetic
    rows = np.unique(np.linspace(0, len(table) - 1, min(len(table), MOST)).round().astype(int))
    angles = np.degrees(table[["longitude", "latitude"]].to_numpy()[rows]).round(DECIMALS)
    heights = table["height"].to_numpy()[rows].round(3)
    time = solution.trajectory.index.to_numpy()[rows]
    return np.column_stack([angles, heights]).tolist(), time.tolist()


def _feature(geometry: dict, properties: dict) -> dict:
    return {"type": "Feature", "geometry": geometry, "properties": properties}


def _placemark(document: ElementTree.Element, name: str) -> ElementTree.Element:
    placemark = ElementTree.SubElement(document, "Placemark")
    ElementTree.SubElement(placemark, "name").text = name
    return placemark


def _pair(place: Sequence[float]) -> str:
    return f"{place[0]:.{DECIMALS}f},{place[1]:.{DECIMALS}f}"
