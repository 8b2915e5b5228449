"""Build the documentation: pages of the folder docs, and those that the library, its data and the workflow give."""

from pathlib import Path
from shutil import copy, copytree
from tempfile import TemporaryDirectory

import pandas as pd
from sphinx.cmd.build import build_main

from imugap.analysis.effect_description import axis_of
from imugap.figures.effects import picture
from imugap.site import devices, effects, formats, limits, paper, reference, reproduce
from imugap.workflow import run_records
from imugap.workflow.job_log import job
from imugap.workflow.products import write_figure

PAPER = Path("results/paper")
"""Folder of the paper as a web page, where it has been made."""


def generated(scores, outputs):
    """Return the text of each generated page by name."""
    return {
        "effects": effects.page("generated"),
        "logs": formats.logs(),
        "fixes": formats.fixes(),
        "start_models": formats.start_models(),
        "targets": formats.targets(),
        "conventions": formats.conventions(),
        "devices": devices.page(),
        "paper": paper.link(PAPER.is_dir()),
        "limits": limits.page(*map(pd.read_csv, scores)),
        "reproduce": reproduce.page([reproduce.RuleOutput(*one) for one in outputs], run_records.read(".")),
        "api": reference.page(),
    }


def write_sources(folder, source, outputs):
    """Lay the sources of all pages out in a folder."""
    copytree("docs", folder, dirs_exist_ok=True)
    (folder / "generated").mkdir()
    for name, text in generated(source.scores, outputs).items():
        (folder / "generated" / f"{name}.md").write_text(text)
    for name, effect in effects.examples().items():
        if name in effects.drawn():
            write_figure(picture(effect, axis_of(effect)), folder / "generated" / f"{name}.png", "png")
    copy(source.changes, folder / "generated")
    copy(source.picture, folder)
    (folder / "notebooks").mkdir()
    for path in source.notebooks:
        copy(path, folder / "notebooks")
    for path in source.plugin:
        copy(path, folder)


with job(snakemake) as (source, params, output), TemporaryDirectory() as temporary:
    folder = Path(temporary)
    write_sources(folder, source, params.outputs)
    faults = build_main(["--builder", "html", "--fail-on-warning", "--quiet", str(folder), output.site])
    if faults:
        raise RuntimeError(f"site: expected pages without a warning of Sphinx; found {faults}")
    if PAPER.is_dir():
        copytree(PAPER, Path(output.site) / "paper")
