"""Readers of the files of the catalogue in their own formats and units: convert to SI, check.

Recordings of a user are read by :func:`imugap.io.recording.read`, fixes by :func:`imugap.io.fixes.reading.read`.
"""

import warnings
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.csv
from scipy.spatial.transform import Rotation

from imugap.io.catalogue.datasets import EVENTS, LOG, POSITIONS, DataSet, RawFiles
from imugap.io.formats.source import extra
from imugap.io.references import reference
from imugap.io.rows import advances
from imugap.kinematics.strapdown import POSITION
from imugap.log import COLUMNS, LogError, check
from imugap.units import to_si

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
        A Reference (:mod:`imugap.io.references.reference`), only the instants at which it is known.
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


def _rda(path: Path) -> np.ndarray:
    with extra(path, "r", "rdata"):
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


RECORDINGS = {
    ".rda": _rda,
    ".npy": _npy,
    ".mat": _mat,
    ".csv": _csv_samples,
    ".txt": _txt,
    ".parquet": _parquet_samples,
}
