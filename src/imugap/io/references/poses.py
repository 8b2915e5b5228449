"""Poses of a device over time, from motion capture or from a trajectory: files as people have them.

Recognised by content: EuRoC/ASL tables (stamps in ns, position, quaternion with the scalar first, velocity), TUM
trajectories (seconds, position, quaternion with the scalar last), and tables with a header that names the columns.
"""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from imugap.io.formats import text
from imugap.io.rows import require_range
from imugap.kinematics.error_free import POSITION, QUATERNION, VELOCITY
from imugap.log import ACCEL, GYRO, TIME, LogError

ASL = (TIME, *POSITION, "quat_w", "quat_x", "quat_y", "quat_z", *VELOCITY)
"""Columns of an ASL table without a header; more may follow."""
ASL_BIASES = (*GYRO, *ACCEL)
"""Columns of an ASL table after :data:`ASL`: the biases of the publisher's estimate."""
TUM = (TIME, *POSITION, *QUATERNION)
"""Columns of a TUM trajectory."""
LARGEST_S = 1e11
"""Stamps above it are not in seconds: as such they would be later than the year 5000."""
NANO = 1e-9
EXCERPT = 80
"""Largest number of characters of a message taken from a file."""
UNIT_TOLERANCE = 0.02
"""Largest difference of the norm of a quaternion from one."""
NAMES = {
    TIME: r"(time|timestamp|t)(_?\[?(s|ns)\]?)?",
    **{f"quat_{one}": rf"(q|quat|orientation|rotation|q_rs)[_.]?{one}" for one in "wxyz"},
    **{name: rf"(p|pos|position|t|p_rs_r|translation)?[_.]?{one}" for one, name in zip("xyz", POSITION, strict=True)},
    **{name: rf"(v|vel|velocity|v_rs_r)[_.]?{one}" for one, name in zip("xyz", VELOCITY, strict=True)},
}
"""Canonical name of a column to the pattern of its name in a header, without blanks and units, in lower case."""


def read_poses(path: str | Path) -> pd.DataFrame:
    """Read the poses of a device.

    Returns
    -------
    DataFrame
        Index ``time`` [s], strictly increasing; columns :data:`imugap.kinematics.error_free.QUATERNION` and, as far as
        the file has them, ``POSITION`` [m] and ``VELOCITY`` [m/s] of the same module. Rows without a number are left
        out.

    Raises
    ------
    LogError
        With the place, what was expected and what was found.
    """
    path = Path(path)
    table = _table(path)
    missing = [name for name in (TIME, *QUATERNION) if name not in table]
    if missing:
        raise LogError(path, "columns", "a time and the four components of a quaternion", f"no {missing[0]}")
    names = [*QUATERNION, *(one for group in (POSITION, VELOCITY) if set(group) <= set(table) for one in group)]
    table = table[[TIME, *names]].replace([np.inf, -np.inf], np.nan).dropna()
    if len(table) < 2:
        raise LogError(path, "rows", "at least 2 poses", str(len(table)))
    time = table[TIME].to_numpy(float)
    step = NANO if time[0] > LARGEST_S else 1.0
    late = np.flatnonzero(np.diff(time) <= 0)
    if len(late):
        raise LogError(path, f"pose {late[0] + 1}", "a time that increases", f"{time[late[0] + 1]:.17g}")
    require_range(dict(table[names].items()), path, lambda row: f"pose {row}")
    norm = np.linalg.norm(table[list(QUATERNION)], axis=1)
    odd = np.flatnonzero(np.abs(norm - 1) > UNIT_TOLERANCE)
    if len(odd):
        raise LogError(path, f"pose {odd[0]}", "a quaternion of norm 1", f"norm {norm[odd[0]]:.4g}")
    return table.set_index(pd.Index(time * step, name=TIME))[names]


def read_biases(path: str | Path) -> pd.DataFrame:
    """Read the biases that the publisher of an ASL table estimated.

    Returns
    -------
    DataFrame
        A row for each pose, columns :data:`imugap.log.GYRO` [rad/s] and :data:`imugap.log.ACCEL` [m/s^2].
    """
    source = text.open_source(Path(path), None)
    names = (*ASL, *ASL_BIASES)
    if len(source.names) != len(names):
        raise LogError(path, "columns", f"the {len(names)} columns of an ASL table with biases", str(len(source.names)))
    values = source.load(range(len(ASL), len(names)), None)[0]
    return pd.DataFrame(dict(zip(ASL_BIASES, values, strict=True)))


def _table(path: Path) -> pd.DataFrame:
    """Return the columns of a text that are recognised, by their canonical names."""
    source = text.open_source(path, None)
    columns = range(len(source.names))
    values = dict(enumerate(source.load(columns, None)[0]))
    if any(source.names):
        named = _named(source.names)
        if not set(QUATERNION) <= set(named):
            expected = "names of a time and a quaternion, such as time, qw, qx, qy, qz"
            raise LogError(path, source.heading, expected, ", ".join(source.names)[:EXCERPT])
        return pd.DataFrame({name: values[index] for name, index in named.items()})
    nano = values[0][0] > LARGEST_S
    if not nano and len(columns) != len(TUM):
        raise LogError(path, "columns", "a header, stamps in ns (ASL), or 8 columns (TUM)", f"{len(columns)} columns")
    return pd.DataFrame({name: values[index] for index, name in enumerate(ASL if nano else TUM) if index in values})


def _named(header: Sequence[str]) -> dict[str, int]:
    """Return the index of each canonical column in a header."""
    plain = [re.sub(r"\s*[\[(].*[\])]\s*$|[\s#]", "", name).lower() for name in header]
    matches = {name: [k for k, one in enumerate(plain) if re.fullmatch(form, one)] for name, form in NAMES.items()}
    return {name: found[0] for name, found in matches.items() if found}
