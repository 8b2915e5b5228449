"""Messages sensor_msgs/NavSatFix of a ROS bag of either version, with the velocities of the receiver.

Velocities are messages geometry_msgs/TwistStamped or TwistWithCovarianceStamped in east, north, up, as drivers of
receivers write them. Such messages may hold anything, such as a command to a robot: they are taken if they agree with
the positions.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from imugap.io.fixes.decoded import Decoded
from imugap.io.fixes.receiver_settings import ReceiverSettings
from imugap.io.formats import rosbag
from imugap.kinematics.earth import SEMI_MAJOR_AXIS
from imugap.log import TIME

NAVSAT = "sensor_msgs/msg/NavSatFix"
TWIST, TWIST_COVARIANCE = "geometry_msgs/msg/TwistStamped", "geometry_msgs/msg/TwistWithCovarianceStamped"
EAST, NORTH, UP = 0, 4, 8
"""Places of the variances in the covariance, which is in east, north, up."""
TWIST_PLACES = (7, 0, 14)
"""Places of the variances north, east and up in the covariance of a twist."""
NEAR_S = 0.1
"""Longest time between a velocity and its fix [s]."""
AGREES = 0.5
"""Largest ratio of the differences from the velocities of the positions to these."""
VELOCITIES = ("vel_n", "vel_e", "vel_d", "sd_vel_n", "sd_vel_e", "sd_vel_d")


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file or folder is a bag."""
    return rosbag.recognises(path, head)


def decode(path: Path, settings: ReceiverSettings) -> Decoded:
    """Return the fixes of one topic; messages without a fix are left out."""
    rows = []
    with rosbag.reader_of(path) as reader:
        topic, _ = rosbag.topic_of(reader, path, (NAVSAT,), settings.topic)
        for message, time in rosbag.messages(reader, topic):
            if message.status.status >= 0:
                stamp = rosbag.stamp_of(message) or time
                variances = np.asarray(message.position_covariance)[[NORTH, EAST, UP]]
                deviations = np.sqrt(np.where(variances > 0, variances, np.nan))
                known = deviations if message.position_covariance_type else np.full(3, np.nan)
                rows.append((stamp / 1e9, message.latitude, message.longitude, message.altitude, *known))
        names = [TIME, "latitude", "longitude", "height", "sd_n", "sd_e", "sd_d"]
        table = pd.DataFrame(rows, columns=names).set_index(TIME)
        notes = [f"topic {topic}"]
        for other in dict.fromkeys(one.topic for one in reader.connections if one.msgtype in (TWIST, TWIST_COVARIANCE)):
            found = _velocities(reader, other, table.index.to_numpy())
            if "vel_n" not in table and _agrees(table, found):
                table[list(VELOCITIES)] = found.to_numpy()
                notes.append(f"velocity of {other} in east, north, up")
            else:
                notes.append(f"left out {other}")
    return Decoded(table.dropna(axis=1, how="all"), tuple(notes), "message {}".format)


def _velocities(reader, topic: str, time: np.ndarray) -> pd.DataFrame:
    """Return the velocities of a topic nearest to the fixes, and their deviations; NaN where none is near."""
    rows = []
    for message, stamp in rosbag.messages(reader, topic):
        twist = message.twist
        variances = np.full(3, np.nan)
        if hasattr(twist, "covariance"):
            variances, twist = np.asarray(twist.covariance)[[*TWIST_PLACES]], twist.twist
        linear = twist.linear
        deviations = np.sqrt(np.where(variances > 0, variances, np.nan))
        rows.append(((rosbag.stamp_of(message) or stamp) / 1e9, linear.y, linear.x, -linear.z, *deviations))
    table = pd.DataFrame(sorted(rows), columns=[TIME, *VELOCITIES]).astype(float).set_index(TIME)
    return table[~table.index.duplicated()].reindex(time, method="nearest", tolerance=NEAR_S)


def _agrees(fixes: pd.DataFrame, velocities: pd.DataFrame) -> bool:
    """Return whether velocities are those of the positions, as far as the vehicle moves."""
    time, latitude = fixes.index.to_numpy(), np.radians(fixes["latitude"].to_numpy())
    degree = np.radians(1.0) * SEMI_MAJOR_AXIS
    moved = np.column_stack([fixes["latitude"], fixes["longitude"] * np.cos(latitude)]) * degree
    middle = velocities[["vel_n", "vel_e"]].rolling(2).mean().to_numpy()[1:]
    ahead = np.diff(time) > 0
    steps = np.diff(moved, axis=0)[ahead] / np.diff(time)[ahead, None]
    speed, apart = np.hypot(*steps.T), np.hypot(*(middle[ahead] - steps).T)
    known = np.isfinite(speed) & np.isfinite(apart)
    if not known.any():
        return False
    fast = known & (speed >= np.median(speed[known]))
    return bool(np.median(apart[fast]) <= AGREES * np.median(speed[fast]))
