"""Mutations of sound inputs: logs and fixes (CSV, Parquet), models, configurations, and tables of the catalogue.

Each takes a named random stream, so that a case is known by its number alone.
"""

import zipfile
from collections.abc import Callable
from dataclasses import fields
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd
import yaml
from scipy.io import savemat
from tests.io.devices import write_ulog

from imugap.effects import CATALOGUE
from imugap.log import AXES
from imugap.model import LARGEST, ErrorModel

NUMBERS = (
    "nan", "inf", "-inf", "1e308", "-1e308", "1e-308", "5e-324", "1e160", "1e-160", "0", "-0.0", "-1", "1", "1e9",
    "-1e9", "1e22", "1e400", "9" * 500,  "0100", "1:30", "1_000", "0x1f", "1,5", "true", "null", "", " ", "''", "one",
    "\x00", "Ω", "1e-30", "1e30", "0.1", "1e-12", "123456789012345678",
)  # fmt: skip
"""Texts in the place of a number."""
NODES = (
    "[]", "{}", "[1, 2]", "{a: 1}", "[[[]]]", "&a [*a]", "*b", "!!python/none", "null", "~", "text", "!x 1", "<<",
    "yes", "[" * 50, "{" * 50, '"', "'", "|", ">", "%", "@", "- - -", "? 1",
)  # fmt: skip
"""Texts in the place of a value of YAML."""

Rng = np.random.Generator


def table_values(table: pd.DataFrame, rng: Rng) -> pd.DataFrame:
    """Change values, stamps or rows of a table, index included, so that it still has the form of a log."""
    table = table.reset_index()
    changes = rng.choice(len(TABLE_CHANGES), size=rng.integers(1, 3), replace=False)
    for change in changes:
        if len(table) > 2 and _single(table):
            table = TABLE_CHANGES[change](table, rng)
    return table


def _column(table: pd.DataFrame, rng: Rng) -> str:
    return str(rng.choice(_single(table)))


def _single(table: pd.DataFrame) -> list[str]:
    """Return the names of the columns that are there once."""
    return list(table.columns.drop_duplicates(keep=False))


def _cell(table, rng):
    row, name = rng.integers(len(table)), _column(table, rng)
    text = str(rng.choice(NUMBERS))
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    return table.assign(**{name: table[name].where(np.arange(len(table)) != row, value)})


def _scaled(table, rng):
    name = _column(table, rng)
    return table.assign(
        **{name: table[name] * rng.choice([-1, 0, 1e-300, 1e-12, 1e-3, 57.3, 1e3, 1e9, 1e12, 1e150, 1e300])}
    )


def _shifted(table, rng):
    name = _column(table, rng)
    return table.assign(**{name: table[name] + rng.choice([-1e3, 1e3, 1e9, 1.7e9, 1.7e18, 1e100])})


def _constant(table, rng):
    name = _column(table, rng)
    return table.assign(**{name: rng.choice([0.0, 1.0, -9.81, 1e-300])})


def _all_constant(table, rng):
    return table.assign(**{name: 0.1 for name in table if name != "time"})


def _one_differs(table, rng):
    values = np.zeros(len(table))
    values[rng.integers(len(table))] = rng.choice([1.0, 1e-9, 1e9])
    return table.assign(**{_column(table, rng): values})


def _alternating(table, rng):
    return table.assign(**{_column(table, rng): np.resize([-1.0, 1.0], len(table))})


def _ramp(table, rng):
    return table.assign(**{_column(table, rng): np.arange(len(table)) * rng.choice([1e-5, 1.0])})


def _square(table, rng):
    period = int(rng.integers(2, 50))
    return table.assign(**{_column(table, rng): (np.arange(len(table)) // period % 2).astype(float)})


def _rounded(table, rng):
    name = _column(table, rng)
    step = rng.choice([1e-6, 1e-3, 1.0, 10.0])
    return table.assign(**{name: np.round(table[name] / step) * step})


def _heavy(table, rng):
    name = _column(table, rng)
    return table.assign(**{name: table[name] * (1 + rng.standard_cauchy(len(table)))})


def _missing(table, rng):
    name, share = _column(table, rng), rng.choice([0.01, 0.5, 1.0])
    return table.assign(**{name: table[name].where(rng.uniform(size=len(table)) > share)})


def _repeated(table, rng):
    row = rng.integers(len(table))
    return pd.concat([table.iloc[: row + 1], table.iloc[row:]], ignore_index=True)


def _reversed(table, rng):
    return table.iloc[::-1].reset_index(drop=True)


def _swapped(table, rng):
    order = np.arange(len(table))
    one, other = rng.integers(len(table), size=2)
    order[[one, other]] = order[[other, one]]
    return table.iloc[order].reset_index(drop=True)


def _gap(table, rng):
    first, last = np.sort(rng.integers(len(table), size=2))
    return table.drop(index=table.index[first:last]).reset_index(drop=True)


def _decimated(table, rng):
    return table.iloc[:: int(rng.integers(2, 9))].reset_index(drop=True)


def _thinned(table, rng):
    return table[rng.uniform(size=len(table)) > rng.choice([0.05, 0.5, 0.9])].reset_index(drop=True)


def _short(table, rng):
    return table.iloc[: int(rng.choice([0, 1, 2, 3, 5, 20, 256, 320]))]


def _stepped(table, rng):
    if list(table.columns).count("time") != 1:
        return table
    row = rng.integers(len(table))
    return table.assign(time=table["time"] + (np.arange(len(table)) > row) * rng.choice([-5.0, 1e-9, 1.0, 1e6]))


def _jittered(table, rng):
    if list(table.columns).count("time") != 1:
        return table
    return table.assign(time=table["time"] + rng.normal(0, rng.choice([1e-6, 1e-3, 0.1]), len(table)))


def _without(table, rng):
    return table.drop(columns=_column(table, rng))


def _renamed(table, rng):
    return table.rename(columns={_column(table, rng): str(rng.choice(["gyro_X", "ax", "", "time", "a\tb", "Ω" * 500]))})


def _added(table, rng):
    return table.assign(
        **{str(rng.choice(["temperature", "extra", "accel_z", "label"])): rng.choice([0.0, 25.0, np.nan])}
    )


TABLE_CHANGES: tuple[Callable[[pd.DataFrame, Rng], pd.DataFrame], ...] = (
    _cell, _scaled, _shifted, _constant, _all_constant, _one_differs, _alternating, _ramp, _square, _rounded, _heavy,
    _missing, _repeated, _reversed, _swapped, _gap, _decimated, _thinned, _short, _stepped, _jittered, _without,
    _renamed, _added,
)  # fmt: skip


def text_bytes(content: bytes, rng: Rng) -> bytes:
    """Damage the bytes of a text of lines and cells."""
    for _ in range(rng.integers(1, 4)):
        content = TEXT_CHANGES[rng.integers(len(TEXT_CHANGES))](content, rng)
    return content


def _at(content: bytes, rng: Rng) -> int:
    return int(rng.integers(len(content) + 1))


def _flip(content, rng):
    at = min(_at(content, rng), max(len(content) - 1, 0))
    return content[:at] + bytes([int(rng.integers(256))]) + content[at + 1 :]


def _cut(content, rng):
    return content[: _at(content, rng)]


def _inserted(content, rng):
    at = _at(content, rng)
    token = rng.choice(
        [*NUMBERS, *NODES, "\ufeff", "\r", "\n\n", "\x1b[31m", "#", ";", "\t", ":", ",", '"', "x" * 5000]
    )
    return content[:at] + str(token).encode() + content[at:]


def _cell_replaced(content, rng):
    cells = content.replace(b"\n", b",\n").split(b",")
    at = int(rng.integers(len(cells)))
    cells[at] = cells[at][: len(cells[at]) - len(cells[at].lstrip(b"\n"))] + str(rng.choice(NUMBERS)).encode()
    return b",".join(cells).replace(b",\n", b"\n")


def _line_doubled(content, rng):
    lines = content.splitlines(keepends=True) or [b""]
    at = int(rng.integers(len(lines)))
    return b"".join([*lines[:at], lines[at], *lines[at:]])


def _line_dropped(content, rng):
    lines = content.splitlines(keepends=True) or [b""]
    at = int(rng.integers(len(lines)))
    return b"".join(lines[:at] + lines[at + 1 :])


def _other_delimiter(content, rng):
    return content.replace(b",", [b";", b"\t", b" ", b",,"][int(rng.integers(4))])


def _other_line_ends(content, rng):
    return content.replace(b"\n", [b"\r\n", b"\r", b"", b"\n\n", b"\x0b"][int(rng.integers(5))])


def _wide(content, rng):
    return content.decode("latin-1").encode("utf-16")


def _nothing(content, rng):
    return b""


TEXT_CHANGES: tuple[Callable[[bytes, Rng], bytes], ...] = (
    _flip, _cut, _inserted, _inserted, _cell_replaced, _cell_replaced, _line_doubled, _line_dropped, _other_delimiter,
    _other_line_ends, _wide, _nothing,
)  # fmt: skip


def parquet_bytes(table: pd.DataFrame, rng: Rng) -> bytes:
    """Write a table as Parquet with other types, or with damaged bytes."""
    kind = rng.integers(5)
    if kind == 0:
        with np.errstate(over="ignore"):
            table = table.astype("float32")
    elif kind == 1:
        table = table.astype({str(rng.choice(list(table.columns))): str})
    elif kind == 2:
        table = table.set_index(table.columns[0])
    buffer = BytesIO()
    table.columns = [str(name) for name in table.columns]
    table.to_parquet(buffer)
    content = buffer.getvalue()
    return _flip(_cut(content, rng), rng) if kind == 3 else _flip(content, rng) if kind == 4 else content


def array_file(table: pd.DataFrame, rng: Rng) -> tuple[str, bytes]:
    """Write a table as arrays of NumPy or MATLAB or as a PX4 log, some of odd types or shapes, some damaged."""
    name, content = ARRAY_FILES[rng.integers(len(ARRAY_FILES))](table, rng)
    kind = rng.integers(4)
    return name, _cut(content, rng) if kind == 0 else _flip(content, rng) if kind == 1 else content


def _saved(values: np.ndarray, pickled: bool = False) -> tuple[str, bytes]:
    buffer = BytesIO()
    np.save(buffer, values, allow_pickle=pickled)
    return "log.npy", buffer.getvalue()


def _plain(table, rng):
    with np.errstate(all="ignore"):
        return _saved(table.to_numpy(float).astype(str(rng.choice(["f8", "f2", "c16", "i8", "?", ">f4", "S8"]))))


def _structured(table, rng):
    return _saved(
        np.array(list(table.itertuples(index=False)), [(f"{name}_{k}", "f8") for k, name in enumerate(table)])
    )


def _shaped(table, rng):
    values = table.to_numpy(float)
    shapes = [
        values.T,
        values[None],
        values.reshape(-1),
        values[:0],
        values[:, :1],
        values[:1].ravel(),
        np.float64(1.0),
    ]
    return _saved(shapes[rng.integers(len(shapes))])


def _objects(table, rng):
    return _saved(np.array([{"a": 1}, None, "text"], dtype=object), pickled=True)


def _matlab(table, rng):
    values = table.to_numpy(float)
    contents = [
        {}, {"text": "no samples"}, {"imu": values, "fs": float(rng.choice([0.0, -1.0, 25.0, 1e300, np.nan]))},
        {"imu": {"time": values[:, 0], "gyro": values[:, 1:]}}, {"imu": np.array([values, 1.0], dtype=object)},
        {"imu": np.stack([values, values])}, {name: values[:k] for k, name in enumerate("abc")},
    ]  # fmt: skip
    buffer = BytesIO()
    savemat(buffer, contents[rng.integers(len(contents))])
    return "log.mat", buffer.getvalue()


def _flown(table, rng):
    values = table.to_numpy(float)
    rows = np.zeros(len(values), [("timestamp", "<u8"), *((f"gyro_rad_{k}", "<f4") for k in range(values.shape[1]))])
    stamps = [np.arange(len(values)) * 40_000, np.zeros(len(values)), rng.permutation(len(values))]
    rows["timestamp"] = stamps[rng.integers(3)]
    with np.errstate(all="ignore"):
        for k, column in enumerate(values.T):
            rows[f"gyro_rad_{k}"] = column
    message = str(rng.choice(["sensor_combined", "sensor_gyro:1", "other"]))
    with TemporaryDirectory() as folder:
        return "log.ulg", write_ulog(Path(folder) / "log.ulg", {message: rows}).read_bytes()


def _archived(table, rng):
    content = BytesIO()
    names = ["Gyroscope.csv", "Accelerometer.csv", "Location.csv", "../Gravity.csv", "meta/time.csv", "x.csv"]
    with zipfile.ZipFile(content, "w") as archive:
        for name in rng.choice(names, size=rng.integers(0, 4), replace=False):
            kept = table.rename(columns=dict(zip(table.columns[1:4], rng.permutation(list("xyz")), strict=False)))
            archive.writestr(str(name), text_bytes(kept.to_csv(index=False).encode(), rng))
    return "log.zip", content.getvalue()


ARRAY_FILES: tuple[Callable[[pd.DataFrame, Rng], tuple[str, bytes]], ...] = (
    _plain, _structured, _shaped, _objects, _matlab, _matlab, _flown, _archived,
)  # fmt: skip


def fix_file(fixes: pd.DataFrame, rng: Rng) -> tuple[str, bytes]:
    """Write fixes, in degrees, as NMEA, GPX or RTKLIB has them, with cells, lines or bytes damaged."""
    name, lines = FIX_FILES[rng.integers(len(FIX_FILES))](fixes)
    return name, text_bytes("\n".join(lines).encode(), rng)


def _nmea(fixes):
    lines = []
    for time, one in fixes.iterrows():
        clock = f"{int(time // 3600):02d}{int(time // 60 % 60):02d}{time % 60:05.2f}"
        places = (
            f"{int(abs(x)):0{wide}d}{abs(x) % 1 * 60:07.4f}" for x, wide in ((one.latitude, 2), (one.longitude, 3))
        )
        text = (
            f"GPGGA,{clock},{','.join(f'{place},{side}' for place, side in zip(places, 'NE', strict=True))},4,12,0.8,"
        )
        text += f"{one.height:.2f},M,0,M,,"
        checksum = 0
        for letter in text.encode():
            checksum ^= letter
        lines.append(f"${text}*{checksum:02X}")
    return "fixes.nmea", lines


def _gpx(fixes):
    points = [
        f'<trkpt lat="{one.latitude:.8f}" lon="{one.longitude:.8f}"><ele>{one.height:.2f}</ele>'
        f"<time>2024-05-01T10:00:{time:05.2f}Z</time></trkpt>"
        for time, one in fixes.loc[:59].iterrows()
    ]
    head = '<?xml version="1.0"?><gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>'
    return "fixes.gpx", [head, *points, "</trkseg></trk></gpx>"]


def _rtklib(fixes):
    head = "%  GPST          latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   sdu(m)"
    rows = [
        f"2024/05/01 10:{int(time // 60):02d}:{time % 60:06.3f} {one.latitude:.9f} {one.longitude:.9f} "
        f"{one.height:.4f} 1 9 0.01 0.01 0.02"
        for time, one in fixes.iterrows()
    ]
    return "fixes.pos", [head, *rows]


FIX_FILES: tuple[Callable[[pd.DataFrame], tuple[str, list[str]]], ...] = (_nmea, _gpx, _rtklib)


def model_text(rng: Rng) -> str:
    """Draw a model of effects of any kind and size, most of them valid, some with a fault in their text.

    Half of the models have what a filter asks for: white noise on each of the six axes.
    """
    spread = rng.choice([2, 6, 11, 29])
    complete = rng.uniform() < 0.5
    axes = AXES if complete else rng.permutation([*AXES, "time"])[: rng.integers(1, 8)].tolist()
    model = {axis: [_effect(rng, axis, spread) for _ in range(rng.integers(0, 4))] for axis in axes}
    if complete:
        noise = {"white_noise": {"density": float(10 ** rng.uniform(-spread, spread))}}
        model = {axis: [noise, *effects] for axis, effects in model.items()}
    text = yaml.dump(model, Dumper=PlainDumper, sort_keys=False)
    if rng.uniform() < 0.2:
        text = text_bytes(text.encode(), rng).decode("utf-8", errors="surrogateescape")
    if rng.uniform() < 0.2:
        text = yaml_values(text, rng)
    return text


class PlainDumper(yaml.SafeDumper):
    """Writer of YAML that repeats a value in full."""

    def ignore_aliases(self, data: object) -> bool:
        return True


def _effect(rng: Rng, axis: str, spread: float) -> dict:
    """Draw an effect, most of them valid on the axis."""
    effect = _any_effect(rng, spread)
    while rng.uniform() < 0.98 and not _valid(axis, effect):
        effect = _any_effect(rng, spread)
    return effect


def _any_effect(rng: Rng, spread: float) -> dict:
    name = str(rng.choice(sorted(CATALOGUE) if rng.uniform() < 0.6 else ["white_noise", "random_walk", "gauss_markov"]))
    values = {}
    for item in fields(CATALOGUE[name]):
        low, high = max(item.metadata["low"], -LARGEST), min(item.metadata["high"], LARGEST)
        sign = rng.choice([1, 1, 1, -1]) if low < 0 else 1
        value = sign * 10 ** rng.uniform(-spread, spread) * (rng.uniform() < 0.9 or low > 0)
        value = float(np.clip(value, low, high))
        values[item.name] = round(value) if item.metadata["whole"] else value
    return {name: values}


def _valid(axis: str, effect: dict) -> bool:
    try:
        ErrorModel.from_mapping({axis: [effect]})
    except ValueError:
        return False
    return True


def yaml_values(text: str, rng: Rng) -> str:
    """Replace a value of a text of YAML by another one, or a key by another key."""
    parts = text.split(": ")
    at = int(rng.integers(len(parts)))
    rest = parts[at].partition("\n")
    parts[at] = str(rng.choice([*NUMBERS, *NODES])) + rest[1] + rest[2]
    return ": ".join(parts)


def configuration_text(schema: dict, rng: Rng) -> str:
    """Draw a configuration of keys of a schema with values of any kind."""
    text = yaml.safe_dump(_drawn(schema, rng), sort_keys=False)
    return yaml_values(text, rng) if rng.uniform() < 0.3 else text


def _drawn(schema: dict, rng: Rng) -> object:
    if "properties" in schema:
        names = [name for name in schema["properties"] if rng.uniform() < 0.3]
        return {name: _drawn(schema["properties"][name], rng) for name in names}
    if rng.uniform() < 0.1:
        return [None, True, "text", [], {}, -1, 0, 1e300][int(rng.integers(8))]
    if schema.get("type") == "boolean":
        return bool(rng.integers(2))
    if "string" in schema.get("type", ()):
        return str(rng.choice(["device.yaml", "none.yaml", "..", "a\nb"]))
    return float(rng.choice([1, 1, -1]) * 10 ** rng.uniform(-12, 12))
