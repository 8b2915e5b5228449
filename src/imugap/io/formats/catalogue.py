"""The formats that are read, in the order in which they are tried; text is the last, for it is nearly anything."""

from pathlib import Path

from imugap.io.formats import (
    ardupilot_text,
    arrays,
    compression,
    dataflash,
    gnss_ins_sim,
    json_records,
    labelled_lines,
    parquet,
    ros_echo,
    rosbag,
    sensor_files,
    serial_monitor,
    tagged_lines,
    text,
    ulog,
    unread,
)
from imugap.io.formats.source import Source, require_file, whole_file
from imugap.log import LogError

FORMATS = (
    parquet, rosbag, ulog, dataflash, arrays, unread, gnss_ins_sim, sensor_files, json_records, ardupilot_text,
    serial_monitor, ros_echo, tagged_lines, labelled_lines, text,
)  # fmt: skip
HEAD_BYTES = 512


def open_source(path: Path, settings) -> Source:
    """Return the columns of a file of a known format, recognised by its content; LogError where there is none."""
    require_file(path, "a log in a known format")
    head = b"" if path.is_dir() else _head(path)
    for one in FORMATS:
        if one.recognises(path, head):
            with whole_file(path):
                return one.open_source(path, settings)
    if compression.recognises(head):
        with whole_file(path):
            return compression.opened(path, head, lambda part: open_source(part, settings))
    raise LogError(path, "file", "a log in a known format", f"bytes that begin with {head[:16]!r}")


def _head(path: Path) -> bytes:
    with path.open("rb") as handle:
        return handle.read(HEAD_BYTES)
