"""Restart of a killed run of the workflow by the same command, without a word about locks.

The process that runs the workflow holds a lock of the system, which ends with it however it ends. Locks of snakemake
that are there while nobody holds it are those of a killed run. The jobs of a killed run end themselves, so that they
write nothing into the products of the next one.
"""

import fcntl
import os
from contextlib import suppress
from pathlib import Path
from socket import gethostname
from threading import Thread
from time import sleep
from typing import TextIO

MAIN = "IMUGAP_MAIN_PROCESS"
"""Environment variable with host and process that runs the workflow, for its jobs."""
WATCH_S = 0.5
"""Time between two looks at this process [s]."""


def begin(folder: str | Path = ".snakemake") -> TextIO:
    """Begin to run the workflow: remove the locks that a killed run has left, and be known to the jobs.

    Parameters
    ----------
    folder
        Folder in which snakemake keeps its records.

    Returns
    -------
    TextIO
        File that is locked, together with those of other runs in the folder, until it is closed.
    """
    folder = Path(folder)
    folder.mkdir(exist_ok=True)
    held = (folder / "running").open("w")
    with suppress(OSError):  # another run, whose locks stay; or a file system without locks
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        for lock in (folder / "locks").glob("*.lock"):
            lock.unlink(missing_ok=True)
    with suppress(OSError):
        fcntl.flock(held, fcntl.LOCK_SH)
    os.environ[MAIN] = f"{gethostname()} {os.getpid()}"
    return held


def end_with_main() -> None:
    """End this process soon after the one that runs the workflow on this host, if there is one."""
    host, _, process = os.environ.get(MAIN, "").partition(" ")
    if host == gethostname():
        Thread(target=_watch, args=(int(process),), daemon=True).start()


def _watch(process: int) -> None:
    while True:
        try:
            os.kill(process, 0)
        except ProcessLookupError:
            os._exit(1)
        except PermissionError:  # it is there, of another user
            pass
        sleep(WATCH_S)
