"""ROS bags: version 1 (``.bag``) and version 2 (a folder, ``.db3`` or ``.mcap``), messages sensor_msgs/Imu.

The units are those of the definition of the message: rad/s and m/s^2.
"""

from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path

import numpy as np

from imugap.io.formats.source import Source, extra
from imugap.log import LogError

MAGIC = (b"#ROSBAG V2.0", b"\x89MCAP0\r\n", b"SQLite format 3\x00")
INDEX = "metadata.yaml"
IMU = "sensor_msgs/msg/Imu"
BATCH = 20_000
"""Messages in a batch."""
NAMES = (
    *(f"angular_velocity.{axis} [rad/s]" for axis in "xyz"),
    *(f"linear_acceleration.{axis} [m/s^2]" for axis in "xyz"),
    "header.stamp [ns]",
    "log.stamp [ns]",
)


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file or folder is a bag."""
    return (path.is_dir() and (path / INDEX).is_file()) or head.startswith(MAGIC)


def open_source(path: Path, settings) -> Source:
    """Return the columns of the messages of one topic; LogError where there is none, or one of several is meant."""
    with reader_of(path) as reader:
        topic, count = topic_of(reader, path, (IMU,), settings.topic)

    def batches(columns: Sequence[int]) -> Iterator[list[np.ndarray]]:
        with reader_of(path) as reader:
            rest = (_row(message, time) for message, time in messages(reader, topic))
            while rows := list(islice(rest, BATCH)):
                yield [_numbers([row[k] for row in rows], k) for k in columns]

    return Source(
        path, NAMES, count, batches, "message {}".format, notes=(f"topic {topic}",), heading="messages", topic=topic
    )


def reader_of(path: Path):
    """Return a reader of a bag of either version; LogError where its package is missing."""
    with extra(path, "ros", "rosbags"):
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    return AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE))


def topic_of(reader, path: Path, kinds: Sequence[str], asked: str | None) -> tuple[str, int]:
    """Return the topic with messages of one of the kinds, and their number; LogError where it is not one."""
    counts: dict[str, int] = {}
    for one in reader.connections:
        if one.msgtype in kinds:
            counts[one.topic] = counts.get(one.topic, 0) + one.msgcount
    if asked in counts:
        return asked, counts[asked]
    if asked is None and len(counts) == 1:
        return next(iter(counts.items()))
    known = ", ".join(counts) or ", ".join(sorted({f"{one.topic} ({one.msgtype})" for one in reader.connections}))
    expected = f"one topic of {' or '.join(kinds)}{' (--topic decides)' if counts else ''}"
    raise LogError(path, "topics", expected, f"{known[:200] or 'no messages'}{f', not {asked}' if asked else ''}")


def messages(reader, topic: str) -> Iterator[tuple[object, int]]:
    """Yield the messages of a topic, and the time at which each was recorded [ns]."""
    chosen = [one for one in reader.connections if one.topic == topic]
    for connection, time, raw in reader.messages(connections=chosen):
        yield reader.deserialize(raw, connection.msgtype), time


def stamp_of(message) -> int:
    """Return the stamp in the header of a message [ns]."""
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def _row(message, time: int) -> tuple:
    rate, force = message.angular_velocity, message.linear_acceleration
    return rate.x, rate.y, rate.z, force.x, force.y, force.z, stamp_of(message), time


def _numbers(values: list, column: int) -> np.ndarray:
    return np.array(values, np.int64 if column >= NAMES.index("header.stamp [ns]") else float)
