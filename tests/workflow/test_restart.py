"""A killed run of the workflow is taken up again: its locks and its jobs are gone."""

import os
import subprocess
import sys
from socket import gethostname

from imugap.workflow import restart


def test_locks_of_a_killed_run_go_and_those_of_a_running_one_stay(tmp_path, monkeypatch):
    monkeypatch.setenv(restart.MAIN, "")
    lock = tmp_path / "locks" / "0.output.lock"
    lock.parent.mkdir()
    lock.write_text("results/indices.csv")
    with restart.begin(tmp_path):
        assert os.environ[restart.MAIN] == f"{gethostname()} {os.getpid()}"
        assert not lock.exists()
        lock.write_text("results/indices.csv")
        other = restart.begin(tmp_path)
        assert lock.exists()
    with restart.begin(tmp_path):
        assert lock.exists()
    other.close()
    with restart.begin(tmp_path):
        assert not lock.exists()


JOB = "from time import sleep; from imugap.workflow.restart import end_with_main; end_with_main(); sleep(0.2); print(1)"


def job(main):
    return subprocess.run([sys.executable, "-c", JOB], env=os.environ | {restart.MAIN: main}, capture_output=True)


def test_a_job_ends_with_the_process_that_runs_the_workflow():
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    found = job(f"{gethostname()} {gone.pid}")
    assert (found.returncode, found.stdout) == (1, b"")
    for main in (f"{gethostname()} {os.getpid()}", f"elsewhere {gone.pid}", ""):
        assert job(main).returncode == 0
