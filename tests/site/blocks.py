"""Code blocks of a page of the documentation: files that it shows, commands, and Python, in their order."""

import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from imu_benchmark import cli as benchmark
from imugap import cli

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"^(`{3,}|:{3,})(?:\{([\w-]+)\} ?)?([\w./]*)\n(.*?)^\1$", re.MULTILINE | re.DOTALL)
CAPTION = re.compile(r"\A(?::\w+:.*\n)*?:caption: (\S+)\n(?::\w+:.*\n)*\n?")
SOURCES = ("Snakefile", "benchmark", "data", "notebooks", "paper", "src", "workflow")
"""What the commands of a page find beside them, as at the top of a clone."""


@dataclass(frozen=True)
class Block:
    """Block: directive or nothing, language or file, and text."""

    directive: str
    language: str
    text: str


def blocks(page):
    """Return the blocks of a page."""
    return [Block(*found.groups("")[1:]) for found in BLOCK.finditer(page.read_text())]


def lay_out(folder):
    """Put the sources of the project into a folder."""
    for name in SOURCES:
        (folder / name).symlink_to(ROOT / name)


def run(page, folder, names):
    """Run the blocks of a page in the working folder, the code of Python in one namespace."""
    for block in blocks(page):
        caption = CAPTION.match(block.text)
        if block.directive == "code-block" and caption:
            (folder / caption[1]).write_text(block.text[caption.end() :])
        elif block.directive == "literalinclude":
            (folder / block.language).write_text((ROOT / "notebooks" / block.language).read_text())
        elif block.language == "bash":
            for line in block.text.splitlines():
                command(shlex.split(line), folder)
        elif block.language == "python":
            exec(compile(block.text, str(page), "exec"), names)


def command(words, folder):
    """Run a command of a page."""
    if words[0] == "imugap":
        assert cli.main(words[1:]) == 0, words
        return
    if words[0] == "imu-benchmark":
        assert benchmark.main(words[1:]) == 0, words
        return
    assert words[:2] == ["snakemake", "--dry-run"], words
    found = subprocess.run([sys.executable, "-m", *words], cwd=folder, capture_output=True, text=True)
    assert found.returncode == 0, found.stderr
