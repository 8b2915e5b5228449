"""Readers of the files of the catalogue in their own formats and units: convert to SI, check.

Recordings of a user are read by :func:`imugap.io.recording.read`, fixes by :func:`imugap.io.fixes.reading.read`.
"""

import csv
import difflib
import warnings
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.csv
from scipy.spatial.transform import Rotation

from imugap.io import reference
from imugap.io.datasets import EVENTS, LOG, POSITIONS, DataSet, RawFiles
from imugap.io.rows import advances
from imugap.kinematics.strapdown import POSITION
from imugap.log import COLUMNS, LogError, check
from imugap.units import to_si

KNOWN = ("time", *COLUMNS)
EXCERPT = 60


def read_raw(path: str | Path, dataset: DataSet, run: int) -> pd.DataFrame:
    """Read one run of a catalogue file as a canonical log, in SI units.

    Without a time column the samples are spaced evenly at the nominal rate of ``dataset``. A row that is equal
    to an earlier one, stamp included, is dropped.
    """
    table = read_raw_table(path, dataset, run)
    return check(table[advances(table.index.to_numpy()) | ~table.reset_index().duplicated().to_numpy()], path)


def read_raw_table(path: str | Path, dataset: DataSet, run: int) -> pd.DataFrame:
    """Read one run of a catalogue file in SI units, unchecked: stamps may repeat, samples may be NaN.

    Input of :func:`imugap.integrity.report.report`.
    """
    path, file = Path(path), dataset.file(run)
    decoders = {".mat": partial(_side_by_side, names=dataset.arrays)} if dataset.arrays else RECORDINGS
    samples = _decoded(path, decoders, f"{file.size_bytes} bytes")
    if samples.ndim == 3 and len(samples) == len(file.runs):
        samples = samples[file.runs.index(run)].T
    width = len(dataset.columns)
    if samples.ndim != 2 or samples.shape[1] != width:
        expected = f"{len(file.runs)} recording(s) of {width} columns ({' '.join(dataset.columns)})"
        raise LogError(path, "shape", expected, " x ".join(map(str, samples.shape)))
    converted = zip(dataset.columns, samples.T, dataset.units, strict=True)
    table = {name: to_si(values.astype(float), unit) for name, values, unit in converted}
    time = pd.Index(table.pop("time", np.arange(len(samples)) / dataset.rate_hz), name="time")
    return pd.DataFrame({name: table[name] for name in COLUMNS if name in table}, index=time)


def read_reference(path: str | Path, dataset: DataSet, run: int) -> pd.DataFrame:
    """Read the reference attitude of one run of a catalogue file, evenly spaced at the nominal rate of ``dataset``.

    Returns
    -------
    DataFrame
        A Reference (:mod:`imugap.io.reference`), only the instants at which it is known.
    """
    path, file = Path(path), dataset.file(run)
    decoders = {".mat": partial(_side_by_side, names=dataset.reference)}
    samples = _decoded(path, decoders, f"{file.size_bytes} bytes")
    if samples.shape[1] != 5:
        raise LogError(path, f"arrays {', '.join(dataset.reference)}", "4 and 1 columns", f"{samples.shape[1]} in all")
    known = np.isfinite(samples).all(axis=1)
    if not known.any():
        raise LogError(path, f"array {dataset.reference[0]}", "quaternions", f"{len(samples)} rows of NaN")
    time = np.flatnonzero(known) / dataset.rate_hz
    quat_ub = Rotation.from_quat(samples[known][:, [1, 2, 3, 0]])
    return reference.from_rotations(time, reference.ENU_TO_NED * quat_ub, samples[known, 4] != 0)


def positions_of(files: RawFiles, run: int) -> pd.DataFrame:
    """Read the reference positions of one run of a data set whose raw files lie here (:func:`read_positions`)."""
    content = POSITIONS if files.dataset.position_rate_hz else LOG
    return read_positions(files.path(run, content), files.dataset, run)


def read_positions(path: str | Path, dataset: DataSet, run: int) -> pd.DataFrame:
    """Read the reference positions of one run of a catalogue file, by the stamps of its log or evenly spaced.

    Parameters
    ----------
    path
        File of the positions, which is that of the log where it contains them.

    Returns
    -------
    DataFrame
        Index ``time`` [s], columns :data:`imugap.kinematics.strapdown.POSITION` [m] from the origin of the reference.
    """
    path = Path(path)
    content = POSITIONS if dataset.position_rate_hz else LOG
    file = dataset.file(run, content)
    names = dataset.positions
    name = names[file.runs.index(run)] if len(names) == len(file.runs) else names[0]
    decoders = {".mat": partial(_side_by_side, names=(name,)), ".csv": partial(_marker, name=name)}
    samples = _decoded(path, decoders, f"{file.size_bytes} bytes")
    if samples.shape[1] != 3:
        raise LogError(path, f"positions {name}", "3 columns", str(samples.shape[1]))
    if dataset.position_rate_hz:
        time = np.arange(len(samples)) / dataset.position_rate_hz
    else:
        time = read_raw_table(path, dataset, run).index.to_numpy()
    columns = [to_si(samples[:, "xyz".index(axis[-1])], dataset.position_unit) for axis in dataset.position_axes]
    signs = [-1.0 if axis.startswith("-") else 1.0 for axis in dataset.position_axes]
    return pd.DataFrame(np.column_stack(columns) * signs, index=pd.Index(time, name="time"), columns=list(POSITION))


def read_strides(path: str | Path, dataset: DataSet, run: int) -> pd.DataFrame:
    """Read the begin and end of the strides of one run of a catalogue file.

    The file has columns ``foot``, ``start`` and ``end``, the latter in samples of the log; its feet, in their order,
    are the runs.

    Returns
    -------
    DataFrame
        Columns ``start``, ``end`` [s].
    """
    table = pd.read_csv(path)
    feet = list(dict.fromkeys(table["foot"]))
    own = table[table["foot"] == feet[dataset.file(run, EVENTS).runs.index(run)]]
    return (own[["start", "end"]] / dataset.rate_hz).reset_index(drop=True)


def _decoded(path: Path, decoders: dict, whole: str) -> pd.DataFrame | np.ndarray:
    """Decode a file by its suffix; any exception becomes a LogError."""
    decode = decoders.get(path.suffix.lower())
    if decode is None:
        raise LogError(path, "file name", f"one that ends in {', '.join(decoders)}", path.suffix or "no ending")
    if not path.is_file():
        raise LogError(path, "file", f"{whole} in {path.suffix} format", "no such file")
    try:
        return decode(path)
    except LogError:
        raise
    except Exception as error:  # decoders raise any kind of exception on a damaged file
        cause = f"{type(error).__name__}: {error}".splitlines()[0]
        found = f"{path.stat().st_size} bytes that cannot be read ({cause[: 4 * EXCERPT]})"
        raise LogError(path, "file", f"{whole} in {path.suffix} format", found) from error


def _csv_table(path: Path, known: tuple[str, ...] = KNOWN) -> pd.DataFrame:
    if path.stat().st_size == 0:
        raise LogError(path, "line 1", f"a header of time and {', '.join(known[1:])}", "an empty file")
    with path.open("rb") as handle:
        header = handle.readline().decode("utf-8-sig", errors="replace")
        handle.seek(-1, 2)
        ended = handle.read() in (b"\n", b"\r")
    if not ended:
        raise _cut_off(path)
    names = [name.strip() for name in next(csv.reader([header], skipinitialspace=True), [])]
    _require_names(names, path, "line 1", known)
    options = pa.csv.ConvertOptions(column_types=dict.fromkeys(names, pa.float64()))
    reading = pa.csv.ReadOptions(column_names=names, skip_rows=1)
    try:
        with path.open("rb") as file:  # the library opens no name that is not UTF-8
            table = pa.csv.read_csv(file, read_options=reading, convert_options=options)
    except pa.ArrowInvalid as error:
        raise _diagnosis(path, names, str(error)) from error
    return table.to_pandas()


def _parquet_table(path: Path, known: tuple[str, ...] = KNOWN) -> pd.DataFrame:
    table = pd.read_parquet(path)
    if table.index.name == "time":
        table = table.reset_index()
    _require_names([str(name) for name in table.columns], path, "columns", known)
    for name in table.columns:
        if table[name].dtype.kind not in "iuf":
            raise LogError(path, f"column {name}", "numbers", str(table[name].dtype))
    return pd.DataFrame({name: table[name].to_numpy(float, na_value=np.nan) for name in table.columns})


def _rda(path: Path) -> np.ndarray:
    import rdata  # takes half a second, and most logs are in other formats

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the R class of the object has no Python constructor, and needs none
        objects = rdata.read_rda(path)
    return _only(objects)


def _npy(path: Path) -> np.ndarray:
    return np.load(path, allow_pickle=False)


def _mat(path: Path) -> np.ndarray:
    from scipy.io import loadmat

    return _only({name: value for name, value in loadmat(path).items() if not name.startswith("__")})


def _side_by_side(path: Path, names: tuple[str, ...]) -> np.ndarray:
    from scipy.io import loadmat

    objects = loadmat(path, variable_names=names)
    absent = [name for name in names if name not in objects]
    if absent:
        raise ValueError(f"expected an array {absent[0]}, found none")
    return np.hstack([objects[name].T if len(objects[name]) == 1 else objects[name] for name in names]).astype(float)


def _only(objects: dict) -> np.ndarray:
    if len(objects) != 1:
        raise ValueError(f"expected one array, found {', '.join(objects) or 'none'}")
    return np.asarray(next(iter(objects.values())), dtype=float)


def _csv_samples(path: Path) -> np.ndarray:
    with path.open(encoding="utf-8") as handle:
        stacked = handle.readline().startswith("sensor,")
    return _sensor_samples(path) if stacked else pa.csv.read_csv(path).to_pandas().to_numpy(float)


def _sensor_samples(path: Path) -> np.ndarray:
    """Return one recording for each sensor, shape (sensors, columns, n), of a table headed by sensor and axis."""
    table = pd.read_csv(path, header=[0, 1], index_col=0)
    sensors = dict.fromkeys(table.columns.get_level_values(0))
    return np.array([table[sensor].to_numpy(float).T for sensor in sensors])


def _marker(path: Path, name: str) -> np.ndarray:
    """Return the columns of one marker of a table headed by marker and axis, shape (n, 3)."""
    return pd.read_csv(path, header=[0, 1], index_col=0)[name][["x", "y", "z"]].to_numpy(float)


def _txt(path: Path) -> np.ndarray:
    """Return specific force and angular rate of each line of a 3DM-GX2 recording, which follow the header byte."""
    lines = path.read_text(encoding="ascii").splitlines()
    return np.array([line.split()[1:7] for line in lines if line.lstrip().startswith("0x")], dtype=float)


def _parquet_samples(path: Path) -> np.ndarray:
    return pd.read_parquet(path).to_numpy(float)


TABLES = {".csv": _csv_table, ".parquet": _parquet_table}
RECORDINGS = {
    ".rda": _rda,
    ".npy": _npy,
    ".mat": _mat,
    ".csv": _csv_samples,
    ".txt": _txt,
    ".parquet": _parquet_samples,
}


def _require_names(names: list[str], path: Path, place: str, known: tuple[str, ...]) -> None:
    """Raise unless ``names`` are ``time``, at least one known column, and nothing else, each once."""
    for name in names:
        if name not in known:
            near = difflib.get_close_matches(name.lower(), known, n=1, cutoff=0.4)
            hint = f" (did you mean {near[0]}?)" if near else ""
            raise LogError(path, place, f"columns among {', '.join(known)}", f"{name[:EXCERPT]!r}{hint}")
    repeated = {name for name in names if names.count(name) > 1}
    if repeated:
        raise LogError(path, place, "every column once", f"{', '.join(sorted(repeated))} more than once")
    if "time" not in names or len(names) < 2:
        raise LogError(path, place, "the column time and at least one other", ", ".join(names) or "nothing")


def _place(path: Path, row: int) -> str:
    """Return the location of data row ``row``: the line of a text file, header and empty lines included."""
    if path.suffix.lower() != ".csv":
        return f"row {row}"
    with path.open("rb") as handle:
        filled = (number for number, line in enumerate(handle, start=1) if line.strip(b"\r\n"))
        return f"line {next(islice(filled, row + 1, None), row + 2)}"


def _cut_off(path: Path) -> LogError:
    with path.open("rb") as handle:
        for number, line in enumerate(handle, start=1):
            last = number, line
    text = last[1].decode("utf-8", errors="replace")[-EXCERPT:]
    expected = "a line end after the last row (add it if the row is whole, remove the row if it is cut off)"
    return LogError(path, f"line {last[0]}", expected, f"the end of the file after {text!r}")


def _diagnosis(path: Path, names: list[str], cause: str) -> LogError:
    """Return the first error in a text file, line by line, after the fast reader failed with ``cause``."""
    with path.open(newline="", encoding="utf-8", errors="replace") as handle:
        rows = csv.reader(handle)
        next(rows)
        for row in filter(None, rows):
            place = f"line {rows.line_num}"
            if len(row) != len(names):
                found = f"{len(row)}: {','.join(row)[:EXCERPT]!r}"
                return LogError(path, place, f"{len(names)} values ({', '.join(names)})", found)
            for name, text in zip(names, row, strict=True):
                if text and not _is_number(text):
                    return LogError(path, f"{place}, column {name}", "a number", repr(text[:EXCERPT]))
    return LogError(path, "text", "rows of numbers", cause.splitlines()[0][: 4 * EXCERPT])


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return "_" not in text
