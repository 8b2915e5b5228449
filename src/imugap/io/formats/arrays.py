"""Arrays of NumPy (``.npy``, ``.npz``), MATLAB (``.mat``, up to version 7.2) and R (``.rda``), with their names."""

import warnings
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from imugap.io.formats import mat_elements
from imugap.io.formats.archive import BEGIN, members
from imugap.io.formats.source import Source, extra
from imugap.io.recognition.column_names import meaning
from imugap.log import LogError

NPY, MAT, HDF = b"\x93NUMPY", b"MATLAB 5.0", b"MATLAB 7.3"
R_STARTS = (b"RDX2", b"RDX3", b"\x1f\x8b", b"BZh", b"\xfd7zXZ")
R_ENDINGS = (".rda", ".rdata")
RATES = ("sampling_rate", "sample_rate", "samplingrate", "samplerate", "sampling_frequency", "fs", "rate_hz")
"""Names of a number that is the sampling rate, in small letters."""
LABELS = "_label"
"""Ending of the name of an array that has the names of the columns of another."""
RUNS_NDIM = 3
"""Number of axes of an array of several runs."""
MOST_COLUMNS = 64
"""An array with fewer rows than that, and more columns, lies on its side."""


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file begins as one of these formats."""
    return (
        head.startswith((NPY, MAT, HDF))
        or _are_arrays(members(path, head))
        or (head.startswith(R_STARTS) and path.suffix.lower() in R_ENDINGS)
    )


def open_source(path: Path, settings) -> Source:
    """Return the columns of all arrays of one length, that of the samples; LogError where there is no table.

    Of an array of several runs (the first axis), the topic is the number of the run.
    """
    with path.open("rb") as handle:
        head = handle.read(len(MAT))
    found = _decoded(path, head)
    run, found = _of_run(found, settings)
    columns: dict[str, np.ndarray] = {}
    for name, value in found.items():
        columns |= _columns(name, value, found.get(f"{name}{LABELS}"))
    tables: dict[int, dict[str, np.ndarray]] = {}
    for name, values in columns.items():
        tables.setdefault(len(values), {})[name] = values
    tables.pop(1, None)
    if not tables:
        shapes = ", ".join(f"{name} {np.shape(value)}".strip() for name, value in found.items())
        runs = max((len(value) for value in found.values() if np.ndim(value) == RUNS_NDIM), default=0)
        several = f" (--topic 0 to {runs - 1} takes one of {runs} runs)" if runs else ""
        raise LogError(path, "arrays", f"a table of samples (rows) and columns{several}", shapes[:200] or "none")
    rows = max(tables, key=lambda length: (sum(map(_inertial, tables[length])), len(tables[length]), length))
    kept = tables[rows]
    loaded = list(kept.values())

    def batches(chosen):
        yield [loaded[k] for k in chosen]

    rates = {name: float(value) for name, value in found.items() if name.lower() in RATES and np.size(value) == 1}
    rate = next(((hertz, name) for name, hertz in rates.items() if 0 < hertz < np.inf), None)
    notes = () if run is None else (f"run {run}",)
    return Source(path, tuple(kept), rows, batches, notes=notes, heading="arrays", topic=run, rate=rate)


def _of_run(found: Mapping[str, object], settings) -> tuple[str | None, Mapping[str, object]]:
    """Return the number of the run that is asked for, and the arrays with it alone; None and all where none is."""
    topic = settings.topic if (settings.topic or "").isdecimal() else None
    if topic is None:
        return None, found
    chosen = {
        name: value[int(topic)]
        for name, value in found.items()
        if np.ndim(value) == RUNS_NDIM and int(topic) < len(value)
    }
    return (topic, {**found, **chosen}) if chosen else (None, found)


def _are_arrays(names: tuple[str, ...] | None) -> bool:
    """Return whether the names in an archive are those of arrays of NumPy."""
    return bool(names) and all(name.endswith(".npy") for name in names)


def _decoded(path: Path, head: bytes) -> Mapping[str, object]:
    if head.startswith(NPY):
        return {"": np.load(path, allow_pickle=False)}
    if head.startswith(BEGIN):
        with np.load(path, allow_pickle=False) as found:
            return dict(found)
    if head.startswith(HDF):
        raise LogError(path, "file", "MATLAB version 7.2 or older (save -v7)", "version 7.3")
    if head.startswith(MAT):
        from scipy.io import loadmat

        mat_elements.require_sound(path)
        found = loadmat(path, squeeze_me=True, struct_as_record=False)
        return {name: value for name, value in found.items() if not name.startswith("__")}
    with extra(path, "r", "rdata"):
        import rdata  # takes half a second, and most logs are in other formats
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the R class of the object has no Python constructor, and needs none
        return rdata.read_rda(path)


def _inertial(name: str) -> bool:
    found = meaning(name)
    return found is not None and found.axis is not None


def _columns(name: str, value: object, given: object = None) -> dict[str, np.ndarray]:
    """Return the columns of an array, a structured array, a table or a structure, by name; ``given`` has the names."""
    if hasattr(value, "_fieldnames"):
        parts = (_columns(field, getattr(value, field)) for field in value._fieldnames)
        return {f"{name}.{field}": values for part in parts for field, values in part.items()}
    if hasattr(value, "columns"):
        return {str(column): value[column].to_numpy() for column in value if value[column].dtype.kind in "iuf"}
    labels = [str(one) for one in value.coords[value.dims[1]].values] if getattr(value, "coords", None) else None
    array = np.asarray(value)
    if array.dtype.names:
        return {field: array[field] for field in array.dtype.names if array[field].ndim == 1}
    if array.dtype.kind not in "iuf" or array.ndim not in (1, 2):
        return {}
    if array.ndim == 1:
        return {name: array}
    table = array.T if len(array) < min(array.shape[1], MOST_COLUMNS) else array
    count = table.shape[1]
    if given is not None and np.size(given) == count:
        labels = [f"{name}.{label}" for label in np.ravel(given)]
    if labels is None or len(labels) != count:
        labels = [f"{name}_{axis}" for axis in "xyz"] if name and count == 3 else [f"{name}[{k}]" for k in range(count)]
    return {label: table[:, k] for k, label in enumerate(labels)}
