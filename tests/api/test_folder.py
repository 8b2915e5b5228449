"""Folders of results: each file in the format of its name, figures in the formats that are asked for."""

from imugap.api.folder import write_folder
from imugap.figures.style import text_figure


def test_figures_have_the_formats_that_are_asked_for_and_none_of_an_earlier_output(tmp_path):
    figure = text_figure("a figure")
    write_folder(tmp_path / "found", {"a.svg": figure, "a.json": 1})
    write_folder(tmp_path / "found", {"a.svg": figure, "a.json": 2}, ("png", "pdf"))
    begins = {path.name: path.read_bytes()[:4] for path in (tmp_path / "found").iterdir()}
    assert begins == {"a.png": b"\x89PNG", "a.pdf": b"%PDF", "a.json": b"2\n"}
    before = {path.name: path.read_bytes() for path in (tmp_path / "found").iterdir()}
    write_folder(tmp_path / "found", {"a.svg": figure, "a.json": 2}, ("png", "pdf"))
    assert {path.name: path.read_bytes() for path in (tmp_path / "found").iterdir()} == before
