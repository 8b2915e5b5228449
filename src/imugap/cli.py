"""The command line: the library on recordings of one's own device."""

import argparse
import errno
import os
import re
import shlex
import signal
import sys
import traceback
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor
from contextlib import contextmanager, nullcontext, suppress
from importlib import import_module
from math import inf
from typing import NoReturn

from imugap import __version__, elapsed, spelling

try:
    import resource
except ImportError:  # no limits of a process on this system
    resource = None

COMMANDS = {
    "check": "verdict on a recording: usable for which command, what was found where, the next step",
    "convert": "recording of any format as a canonical Parquet log",
    "indices": "performance indices of static runs of one device",
    "estimate": "stochastic effects on each axis of a static log, with intervals",
    "discover": "where a simulator and a device disagree, what the model lacks, and how far the discrepancy shrinks",
    "reference": "error-free log of a device from its poses, the reference of discover in motion",
    "walk": "path of a foot with the device on it, corrected whenever the foot stands",
    "drive": "path of a vehicle with the device and a GNSS receiver aboard, with quality control of the fixes",
    "simulate": "static log of a device with an error model",
    "export": "error model as a filter or a simulator takes it",
    "models": "models of real devices by name, with what each was found on and what is not known",
    "effects": "what an effect of an error model is: formula, source, parameters with their units, a picture",
}
"""Name of each module of :mod:`imugap.commands`, and its line of help."""
DEBUG = "IMUGAP_DEBUG"
"""Environment variable that shows the traceback of an error, if it is set to anything."""
CLOSING = f"""examples:
  imugap check run.csv
  imugap estimate run.csv --to kalibr imu.yaml
  imugap estimate --help

Completion in bash: eval "$(register-python-argcomplete imugap)"
With the environment variable {DEBUG}=1 an error shows its traceback."""
LEAST_MEMORY = 3 << 29
"""Bytes of address space that a command needs at least; with less, a library may end the process or wait for ever."""
LONGEST = 1000
"""Largest number of characters of a message."""
PACKAGE = __name__.partition(".")[0]
COMPLETION = "_ARGCOMPLETE"
"""Environment variable that the shell sets where it asks how a word goes on."""
CHOICE = re.compile(r"(argument .+): invalid choice: '(.*)' \(choose from (.+)\)", re.DOTALL)
"""Message of argparse on a value that is none of the choices."""
OPTION = re.compile(r"--[A-Za-z][\w-]*")
FORM = re.compile(r"\bexpected\b.*\bfound\b", re.DOTALL)
"""Form of a message about the input; a ValueError without it is one that nobody has foreseen."""


class CommandParser(argparse.ArgumentParser):
    """Parser whose errors are one line, with the name that was probably meant."""

    def error(self, message: str) -> NoReturn:
        """End with exit code 2 and the message."""
        if choice := CHOICE.fullmatch(message):
            subject, found, choices = choice.groups()
            known = [one.strip("' ") for one in choices.split(",")]
            message = f"{subject}: expected {spelling.expected(found, known)}; found {found!r}"
        _say(f"{self.prog.removeprefix(PACKAGE).strip()}: {message} ({self.prog} --help shows all)".removeprefix(": "))
        self.exit(2)

    def require_known(self, arguments: list[str]) -> None:
        """End with exit code 2 unless every option is one of the parser or the begin of one."""
        known = OPTION.findall(self.format_usage())
        for one in arguments[: arguments.index("--") if "--" in arguments else None]:
            name = one.partition("=")[0]
            if OPTION.fullmatch(name) and not any(option.startswith(name) for option in (*known, "--help")):
                self.error(f"option: expected {spelling.expected(name, known)}; found {name!r}")


class Interrupted(BaseException):
    """A signal that asks the process to end."""


def main(arguments: list[str] | None = None) -> int:
    """Run one command; an error is one message on the standard error, and exit code 1.

    A signal that ends the command gives exit code 128 plus its number, as in a shell.
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError):  # a stream that cannot be configured
            stream.reconfigure(errors="backslashreplace")  # a file name need not be text of the locale
    try:
        with _interruptible():
            options = _options(arguments)
            options.command_line = shlex.join([PACKAGE, *arguments])
            with nullcontext() if options.own_progress else elapsed.shown(options.title):
                code = options.run(options) or 0
            sys.stdout.flush()
    except BrokenPipeError as error:
        if error.filename is not None:
            return _failed(error)
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # else the interpreter flushes it once more
        return 128 + signal.SIGPIPE
    except Interrupted as interrupt:
        return _ended(interrupt)
    except Exception as error:
        interrupt = _interrupt_behind(error)
        return _failed(error) if interrupt is None else _ended(interrupt)
    return code


def _options(arguments: list[str]) -> argparse.Namespace:
    """Parse the arguments; where the shell asks for it, print how a word goes on instead."""
    if COMPLETION in os.environ:
        import argcomplete

        argcomplete.autocomplete(_parser(os.environ["COMP_LINE"].split())[0])
    if _limit() < LEAST_MEMORY:
        least = f"{LEAST_MEMORY >> 20} MB (ulimit -v {LEAST_MEMORY >> 10})"
        raise ValueError(f"memory: expected a limit of at least {least}; found one of {_limit() >> 20} MB")
    parser, chosen = _parser(arguments[:1])
    if chosen is not None:
        chosen.require_known(arguments[1:])
    return parser.parse_args(arguments)


def _parser(chosen: list[str]) -> tuple[CommandParser, CommandParser | None]:
    """Return the parser of all commands, and that of the chosen one, which alone is imported and has its arguments."""
    parser = CommandParser(prog=PACKAGE, description=__doc__, epilog=CLOSING)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    used = None
    parser.add_argument("--version", action="version", version=f"{PACKAGE} {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, title in COMMANDS.items():
        command = commands.add_parser(name, help=title)
        if name in chosen:
            module = import_module(f"imugap.commands.{name}")
            command.set_defaults(run=module.run, title=command.prog, own_progress=False)
            module.add_arguments(command)
            used = command
    return parser, used


@contextmanager
def _interruptible() -> Iterator[None]:
    """Raise :class:`Interrupted` within the block on a signal that asks the process to end.

    The handlers from before are set again behind it. Outside of the main thread nothing is done.
    """

    def interrupt(number: int, _) -> None:
        for one in former:
            signal.signal(one, signal.SIG_IGN)  # the first is heard, and what it cleans up is not disturbed
        raise Interrupted(number)

    former = {}
    try:
        for one in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(one) != signal.SIG_IGN:  # as set by nohup
                former[one] = signal.signal(one, interrupt)
    except ValueError:  # not the main thread
        former = {}
    try:
        yield
    finally:
        for one, handler in former.items():
            signal.signal(one, handler)


def _interrupt_behind(error: BaseException | None) -> Interrupted | None:
    """Return the signal in whose place an error was raised, as a compiler that is interrupted does, or None."""
    while error is not None and not isinstance(error, Interrupted):
        error = error.__cause__ or error.__context__
    return error


def _ended(interrupt: Interrupted) -> int:
    """Say that the command was interrupted, and return the exit code."""
    _say("interrupted")
    return 128 + interrupt.args[0]


def _failed(error: Exception) -> int:
    """Print the message of an error, and return the exit code."""
    if DEBUG in os.environ:
        traceback.print_exception(error)
    _say(_message(error))
    return 1


def _message(error: Exception) -> str:
    """Return what is said of an error: of the input, the system, the memory, or the package itself."""
    match error:
        case _ if _lacks_memory(error):
            return f"memory: expected enough for this input; found none left ({error})"
        case OSError(filename=str() | bytes() as name, strerror=str() as reason):
            return f"{os.fsdecode(name)}: expected a file or folder that can be used; found {reason!r}"
        case BrokenExecutor():
            return "processes: expected workers that end by themselves; found one that the system ended (memory?)"
        case OSError():
            return f"system: expected files and processes that can be used; found {str(error)!r}"
        case ValueError() if FORM.search(str(error)):
            return str(error)
    last = traceback.extract_tb(error.__traceback__)[-1]
    place = f"{os.path.basename(last.filename)}, line {last.lineno}"  # noqa: PTH119
    return (
        f"{place}: expected no such case; found {type(error).__name__}: {error} (an error of {PACKAGE} itself: please "
        f"report it with the traceback, which {DEBUG}=1 shows)"
    )


def _lacks_memory(error: Exception) -> bool:
    """Return whether an error is of memory; that of a library or thread is one where the memory is limited."""
    if isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM:
        return True
    unnamed = isinstance(error, OSError) and error.errno is None  # as of a library that ctypes loads
    return (isinstance(error, ImportError) or unnamed or "start new thread" in str(error)) and _limit() < inf


def _limit() -> float:
    """Return the largest address space of the process [B] (``ulimit -v``)."""
    if resource is None:
        return inf
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    return inf if limit == resource.RLIM_INFINITY else limit


def _say(message: str) -> None:
    """Print a message as one line without control characters."""
    line = " ".join(message.split())
    line = line if len(line) <= LONGEST else f"{line[:LONGEST]} ..."
    plain = "".join(one if one.isprintable() else ascii(one)[1:-1] for one in line)
    with suppress(OSError):  # nobody listens
        print(f"{PACKAGE}: {plain}", file=sys.stderr)
