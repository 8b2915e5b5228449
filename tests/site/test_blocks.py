"""Every code block of the documentation runs as it is written."""

import sys

import pandas as pd
import pytest
from tests.site.blocks import ROOT, blocks, lay_out, run

PAGES = sorted((ROOT / "docs").rglob("*.md"))
QUICK = {"benchmark", "exports", "model"}
"""Pages whose blocks take a few seconds."""
INSTALL = "sh"
"""Language of the commands that set up an environment, which the gate does."""
LANGUAGES = {"bash", "python", "json", INSTALL, ""}


def marked(page):
    return pytest.param(page, id=page.stem, marks=() if page.stem in QUICK else (pytest.mark.slow, pytest.mark.each))


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    """The logs that the first pages make."""
    folder = tmp_path_factory.mktemp("logs")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        run(ROOT / "docs/start/log.md", folder, {})
    return folder


@pytest.mark.parametrize("page", [*map(marked, PAGES)])
def test_the_blocks_of_a_page_run(page, request, tmp_path, monkeypatch):
    if not any(one.language in {"bash", "python"} for one in blocks(page)):
        pytest.skip("the page has no code to run")
    lay_out(tmp_path)
    if page.parent.name == "start":
        for path in request.getfixturevalue("logs").iterdir():
            (tmp_path / path.name).symlink_to(path)
    if page.stem == "log":
        return
    monkeypatch.chdir(tmp_path)
    if page.stem == "ros":
        from tests.io.formats.test_rosbag import write_bag  # the tests of bags need a library that is optional

        write_bag(tmp_path / "imu.bag", "bag", {"/imu": pd.read_csv("run1.csv", index_col=0).to_numpy()})
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    run(page, tmp_path, {"__name__": page.stem})


def test_every_block_is_of_a_kind_that_is_run():
    for page in PAGES:
        for one in blocks(page):
            shown = one.directive in {"code-block", "code-cell", "include", "literalinclude", "toctree"}
            assert shown or one.language in LANGUAGES, (page, one)
        text = page.read_text()
        assert "    $ " not in text
        assert len(blocks(page)) == (text.count("\n```") + text.startswith("```") + text.count("\n:::")) / 2, page
