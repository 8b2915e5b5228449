"""ROS bags: version 1 (``.bag``) and version 2 (a folder, ``.db3`` or ``.mcap``), messages sensor_msgs/Imu.

The units are those of the definition of the message: rad/s and m/s^2. Messages sensor_msgs/Temperature [degC] are
interpolated at the samples. Where one topic has zeros for the forces and another for the rates, as cameras write them,
each gives its own.
"""

from collections.abc import Iterator, Sequence
from itertools import islice, takewhile
from pathlib import Path

import numpy as np

from imugap.io.formats.source import Source, extra
from imugap.log import LogError

MAGIC = (b"#ROSBAG V2.0", b"\x89MCAP0\r\n", b"SQLite format 3\x00")
INDEX = "metadata.yaml"
IMU = "sensor_msgs/msg/Imu"
TEMPERATURE = "sensor_msgs/msg/Temperature"
BATCH = 20_000
"""Messages in a batch."""
FIRST = 100
"""First messages of a topic, which show whether it has rates and forces."""
NAMES = (
    *(f"angular_velocity.{axis} [rad/s]" for axis in "xyz"),
    *(f"linear_acceleration.{axis} [m/s^2]" for axis in "xyz"),
    "header.stamp [ns]",
    "log.stamp [ns]",
)
THERMOMETER = "temperature [degC]"
NONE = (np.nan,) * 3
"""Rates or forces that a topic does not have."""
JOINED = " and "
"""Between the names of two topics that are read together; a name of a topic has no blank."""


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file or folder is a bag."""
    return (path.is_dir() and (path / INDEX).is_file()) or head.startswith(MAGIC)


def open_source(path: Path, settings) -> Source:
    """Return the columns of the messages of one topic; LogError where there is none, or one of several is meant."""
    with reader_of(path) as reader:
        apart = None if settings.topic else _apart(reader)
        topic, count = apart or topic_of(reader, path, (IMU,), settings.topic)
        thermometer, stamps, readings = _temperatures(reader, topic.partition(JOINED)[0])

    def batches(columns: Sequence[int]) -> Iterator[list[np.ndarray]]:
        with reader_of(path) as reader:
            rest = (_row(message, time, apart is not None) for message, time in messages(reader, *topic.split(JOINED)))
            while rows := list(islice(rest, BATCH)):
                at = np.array([row[-2] or row[-1] for row in rows], np.int64)
                yield [
                    np.interp(at - stamps[0], stamps - stamps[0], readings)
                    if k == len(NAMES)
                    else _numbers([row[k] for row in rows], k)
                    for k in columns
                ]

    names = NAMES if thermometer is None else (*NAMES, THERMOMETER)
    notes = (f"topic {topic}", *([] if thermometer is None else [f"temperature of {thermometer}"]))
    return Source(path, names, count, batches, "message {}".format, notes=notes, heading="messages", topic=topic)


def _apart(reader) -> tuple[str, int] | None:
    """Return a topic of rates alone and one of forces alone, joined, and the number of messages.

    None where the bag has no such two topics, or others of the same kind.
    """
    counts: dict[str, int] = {}
    for one in reader.connections:
        if one.msgtype == IMU:
            counts[one.topic] = counts.get(one.topic, 0) + one.msgcount
    if len(counts) != 2:
        return None
    by_holding = {_holds(reader, topic): topic for topic in counts}
    if set(by_holding) != {(True, False), (False, True)}:
        return None
    return JOINED.join((by_holding[True, False], by_holding[False, True])), sum(counts.values())


def _holds(reader, topic: str) -> tuple[bool, bool]:
    """Return whether the first messages of a topic have rates, and forces, that are not zero."""
    first = np.array([_row(*one)[:6] for one in islice(messages(reader, topic), FIRST)]).reshape(-1, 6)
    return bool(first[:, :3].any()), bool(first[:, 3:].any())


def _temperatures(reader, topic: str) -> tuple[str | None, np.ndarray, np.ndarray]:
    """Return the topic of the thermometer, its stamps [ns] and readings; None where no topic or several may be it.

    Of several it is the one whose name shares more with the topic of the samples than the others.
    """
    known = {one.topic for one in reader.connections if one.msgtype == TEMPERATURE and one.msgcount}
    shared = {one: sum(1 for _ in takewhile(lambda parts: parts[0] == parts[1], _levels(one, topic))) for one in known}
    nearest = [one for one in known if shared[one] == max(shared.values())]
    if len(nearest) != 1:
        return None, np.empty(0, np.int64), np.empty(0)
    found = [(stamp_of(message) or time, message.temperature) for message, time in messages(reader, nearest[0])]
    found = sorted(one for one in found if np.isfinite(one[1]))
    if not found:
        return None, np.empty(0, np.int64), np.empty(0)
    return nearest[0], np.array([one[0] for one in found], np.int64), np.array([one[1] for one in found])


def _levels(one: str, other: str) -> Iterator[tuple[str, str]]:
    return zip(one.strip("/").split("/"), other.strip("/").split("/"), strict=False)


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


def messages(reader, *topics: str) -> Iterator[tuple[object, int]]:
    """Yield the messages of topics in the order of their time, and the time at which each was recorded [ns]."""
    chosen = [one for one in reader.connections if one.topic in topics]
    for connection, time, raw in reader.messages(connections=chosen):
        yield reader.deserialize(raw, connection.msgtype), time


def stamp_of(message) -> int:
    """Return the stamp in the header of a message [ns]."""
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def _row(message, time: int, apart: bool = False) -> tuple:
    """Return the values of a message; where rates and forces come ``apart``, NaN for the zeros of the other."""
    rate, force = message.angular_velocity, message.linear_acceleration
    parts = (rate.x, rate.y, rate.z), (force.x, force.y, force.z)
    rates, forces = (NONE if apart and not any(part) else part for part in parts)
    return *rates, *forces, stamp_of(message), time


def _numbers(values: list, column: int) -> np.ndarray:
    return np.array(values, np.int64 if column >= NAMES.index("header.stamp [ns]") else float)
