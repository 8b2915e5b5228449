"""Messages sensor_msgs/NavSatFix of a ROS bag of either version."""

from pathlib import Path

import numpy as np
import pandas as pd

from imugap.io.fixes.decoded import Decoded
from imugap.io.formats import rosbag
from imugap.log import TIME

NAVSAT = "sensor_msgs/msg/NavSatFix"
EAST, NORTH, UP = 0, 4, 8
"""Places of the variances in the covariance, which is in east, north, up."""


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file or folder is a bag."""
    return rosbag.recognises(path, head)


def decode(path: Path, topic: str | None) -> Decoded:
    """Return the fixes of one topic; messages without a fix are left out."""
    rows = []
    with rosbag.reader_of(path) as reader:
        topic, _ = rosbag.topic_of(reader, path, (NAVSAT,), topic)
        for message, time in rosbag.messages(reader, topic):
            if message.status.status >= 0:
                stamp = rosbag.stamp_of(message) or time
                deviations = np.sqrt(message.position_covariance[[NORTH, EAST, UP]])
                known = deviations if message.position_covariance_type else np.full(3, np.nan)
                rows.append((stamp / 1e9, message.latitude, message.longitude, message.altitude, *known))
    names = [TIME, "latitude", "longitude", "height", "sd_n", "sd_e", "sd_d"]
    table = pd.DataFrame(rows, columns=names).set_index(TIME)
    return Decoded(table.dropna(axis=1, how="all"), (f"topic {topic}",), "message {}".format)
