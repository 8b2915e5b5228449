"""The command line: any exception and any signal ends in one line."""

import errno
import multiprocessing
import os
import re
import resource
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from imugap import cli, log
from imugap.discovery.steps import each_in_processes


@pytest.fixture
def failing(monkeypatch, capsys):
    """Run a command that raises an exception; give the exit code and what is said."""

    def run(error):
        def fail(_):
            raise error

        command = SimpleNamespace(add_arguments=lambda parser: None, run=fail)
        monkeypatch.setattr(cli, "import_module", lambda _: command)
        code = cli.main(["check"])
        return code, capsys.readouterr().err

    return run


BUG = r"imugap: test_cli.py, line \d+: expected no such case; found {}.*\(an error of imugap itself: please report it "
ERRORS = [
    (ValueError("log: expected\n  this; found that"), "imugap: log: expected this; found that$"),
    (ValueError("operands could not be broadcast"), BUG.format("ValueError: operands could not be broadcast")),
    (IndexError("list index out of range"), BUG.format("IndexError: list index out of range")),
    (AssertionError(), BUG.format("AssertionError")),
    (RecursionError("deep"), BUG.format("RecursionError: deep")),
    (MemoryError("8 EiB"), r"imugap: memory: expected enough for this input; found none left \(8 EiB\)$"),
    (OSError(errno.ENOMEM, "Cannot allocate memory"), "imugap: memory: expected enough .*Cannot allocate memory"),
    (BrokenProcessPool("abruptly"), "imugap: processes: expected workers that end by themselves; found one that"),
    (ImportError("no such module"), BUG.format("ImportError: no such module")),
    (
        FileNotFoundError(2, "No such file", "a\x1b[31m.csv"),
        r"imugap: a\\x1b\[31m.csv: expected .*; found 'No such file'$",
    ),
    (OSError("odd"), "imugap: system: expected .*; found 'odd'$"),
    (ValueError(f"a: expected b; found {'x' * 10**6}"), r"imugap: a: expected b; found x{900,1000} \.\.\.$"),
]


@pytest.mark.parametrize(("error", "message"), ERRORS, ids=lambda one: type(one).__name__)
def test_every_exception_is_one_line(failing, error, message):
    code, said = failing(error)
    assert code == 1
    assert said.count("\n") == 1
    assert re.match(message, said.rstrip("\n"))


def test_a_traceback_is_shown_on_demand(failing, monkeypatch):
    monkeypatch.setenv(cli.DEBUG, "1")
    code, said = failing(IndexError("list index out of range"))
    assert code == 1
    assert said.startswith("Traceback")
    assert said.splitlines()[-1].startswith("imugap: ")


USAGE = {
    "estimat run.csv": "argument COMMAND: .*did you mean estimate",
    "walk run.csv --outdors --out found": r"walk: option: .*did you mean --outdoors\?\); found '--outdors'",
    "drive a.csv b.csv --fixes_topic=a --out found": "drive: option: .*did you mean --fixes-topic",
    "check run.csv --time-unit sec": "check: argument --time-unit: .*did you mean s",
    "walk run.csv --out found --format jpg": "walk: argument --format: expected .*; found 'jpg'",
    "check run.csv --qqq": "check: option: expected one of .*--topic",
    "walk run.csv": "walk: the following arguments are required: --out",
}


@pytest.mark.parametrize(("line", "message"), USAGE.items(), ids=USAGE)
def test_a_wrong_command_line_is_one_line_with_what_was_meant(capsys, line, message):
    with pytest.raises(SystemExit, match="2"):
        cli.main(line.split())
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert re.match(f"imugap: {message}", said)


@pytest.mark.parametrize("command", cli.COMMANDS)
def test_every_help_has_examples(capsys, command):
    with pytest.raises(SystemExit, match="0"):
        cli.main([command, "--help"])
    assert f"\n  imugap {command}" in capsys.readouterr().out.partition("examples:")[2]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("imugap esti", ["estimate "]), ("imugap walk --outd", ["--outdoors "]),
        ("imugap check --time-unit n", ["ns "]),
        ("imugap effects gauss", ["gauss_markov "]), ("imugap export m.yaml --to kal", ["kalibr "]),
    ],
)  # fmt: skip
def test_the_shell_completes_commands_options_and_values(line, words):
    script = "import os, sys; os.dup2(1, 8); from imugap.cli import main; main([])"
    ask = {"_ARGCOMPLETE": "1", "COMP_LINE": line, "COMP_POINT": str(len(line)), "_ARGCOMPLETE_IFS": "|"}
    found = subprocess.run([sys.executable, "-c", script], env=os.environ | ask, capture_output=True, check=False)
    assert found.stdout.decode().split("|") == words


@pytest.fixture
def heard():
    """No signal is ignored, as it is in what a shell runs in the background."""
    standard = {signal.SIGINT: signal.default_int_handler, signal.SIGHUP: signal.SIG_DFL}
    former = {number: signal.signal(number, handler) for number, handler in standard.items()}
    yield
    for number, handler in former.items():
        signal.signal(number, handler)


def wait_for(number):
    os.kill(os.getpid(), number)
    time.sleep(10)


def wrapped(number):
    """Wait as in a compiler, which turns what interrupts it into an error of its own."""
    try:
        wait_for(number)
    except BaseException as error:
        raise RuntimeError("no code") from error


@pytest.mark.parametrize("wait", [wait_for, wrapped])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_is_said_and_is_the_exit_code(heard, capsys, monkeypatch, number, wait):
    def run(_):
        wait(number)

    before = signal.getsignal(number)
    command = SimpleNamespace(add_arguments=lambda parser: None, run=run)
    monkeypatch.setattr(cli, "import_module", lambda _: command)
    assert cli.main(["check"]) == 128 + number
    assert capsys.readouterr().err == "imugap: interrupted\n"
    assert signal.getsignal(number) == before


POOL = """
import sys, time
from imugap import cli
from imugap.discovery.steps import each_in_processes

def sleep(seconds):
    time.sleep(seconds)

class Command:
    add_arguments = staticmethod(lambda parser: None)

    @staticmethod
    def run(_):
        with each_in_processes(2) as each:
            print("begun", flush=True)
            list(each(sleep, [60, 60, 60]))

cli.import_module = lambda _: Command
sys.exit(cli.main(["check"]))
"""


@pytest.mark.parametrize("wait_s", [0.0, 0.5])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_no_worker_outlives_its_parent(heard, tmp_path, number, wait_s):
    """A signal while the processes start, or while they work, ends all of them without a word of theirs."""
    script = tmp_path / "pool.py"
    script.write_text(POOL)
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "start_new_session": True}
    with subprocess.Popen([sys.executable, str(script)], **options) as process:
        assert process.stdout.readline() == "begun\n"
        time.sleep(wait_s)
        os.killpg(process.pid, number) if number == signal.SIGINT else process.send_signal(number)
        said = process.communicate()[1]  # ends when no process holds the other end
    assert process.returncode == (-number if number == signal.SIGKILL else 128 + number)
    assert said == ("" if number == signal.SIGKILL else "imugap: interrupted\n")


def fail_beside_workers():
    with each_in_processes(2) as each:
        each(time.sleep, [60, 60, 60])
        raise ValueError("failed")


def test_a_pool_ends_with_a_block_that_fails():
    before = set(threading.enumerate())
    with pytest.raises(ValueError, match="failed"):
        fail_beside_workers()
    assert set(threading.enumerate()) == before
    assert not multiprocessing.active_children()


def limited(kilobytes, *arguments):
    """Run a command line in a process of so much address space."""
    code = "import sys; from imugap.cli import main; sys.exit(main())"
    size = kilobytes * 1024
    return subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (size, size)),
    )  # fmt: skip


MODEL = "".join(f"{axis}: [{{white_noise: {{density: 1e-3}}}}]\n" for axis in log.AXES)
LINES = [
    "check log.csv", "convert log.csv --out log.parquet", "indices log.csv --out i.csv",
    "estimate log.csv --out e.json", "discover log.csv --workers 2 --out found",
    "reference log.csv --log log.csv --out r.parquet",
    "walk log.csv --out walk", "drive log.csv log.csv --out drive", "effects gauss_markov --out e.svg",
    "simulate model.yaml --duration 4000 --rate 200 --out s.csv", "export model.yaml --to cpp --rate 9 --out e.hpp",
]  # fmt: skip


@pytest.mark.parametrize(
    ("kilobytes", "lines"),
    [
        (150_000, LINES),
        (1_500_000, LINES[:1]),
        *(pytest.param(size, LINES, marks=pytest.mark.slow) for size in (1_600_000, 1_800_000)),
    ],
)
def test_a_limit_of_memory_is_one_line(tmp_path, monkeypatch, kilobytes, lines):
    monkeypatch.chdir(tmp_path)
    Path("model.yaml").write_text(MODEL)
    noise = np.random.default_rng(1).normal(0, 1e-3, (4000, 6))
    log.write(log.from_samples(dict(zip(log.AXES, noise.T, strict=True)), 0.02), "log.csv")
    before = set(tmp_path.iterdir())
    for line in lines:
        found = limited(kilobytes, *line.split())
        assert "Traceback" not in found.stderr, line
        if found.returncode:
            assert found.returncode == 1, (line, found.stderr)
            assert re.search(r"expected .+; found .+\n$", found.stderr), (line, found.stderr)
            assert cli.DEBUG not in found.stderr, (line, found.stderr)
            assert set(tmp_path.iterdir()) == before, line
        before = set(tmp_path.iterdir())
