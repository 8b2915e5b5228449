"""The paper as a web page: figures are files, every section has an anchor, and it fits a phone."""

import re

import pytest

from imugap.site import paper

typst = pytest.importorskip("typst")

SQUARE = r"<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9\" height=\"9\"><path d=\"M0 0H9V9\"/></svg>"
SOURCE = f"""
#set document(title: "A title")
#set heading(numbering: "1.1")
#set math.equation(numbering: "(1)")
#title()
= First <first>
As in @first and @square.
#figure(image(bytes("{SQUARE}"), alt: "a square"), caption: [Square.]) <square>
#figure(table(columns: 40, ..range(80).map(one => [number #one])), caption: [Wide.])
$ sum_(k=1)^40 {" + ".join(f"a_{k}^2 b_{k}" for k in range(40))} $
= Second *part*
Text.
"""


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paper")
    text, pictures = paper.web_page(typst.compile(SOURCE.encode(), format="html").decode())
    for name, content in pictures.items():
        (folder / name).write_bytes(content)
    (folder / paper.PDF).write_bytes(b"%PDF")
    (folder / "index.html").write_text(text)
    return folder / "index.html"


def test_figures_are_files_with_their_alternative_text(page):
    text = page.read_text()
    assert "data:" not in text
    (name,) = re.findall(r'<img loading="lazy" src="([^"]+)"[^>]* alt="a square"', text)
    assert (page.parent / name).read_bytes().startswith(b"<svg")


def test_every_section_is_in_the_contents_and_every_anchor_is_there(page):
    text = page.read_text()
    contents = re.search(r"<nav.*?</nav>", text).group()
    assert re.findall(r">([^<]+)</a>", contents) == ["1 First", "2 Second part"]
    anchors = re.findall(r' id="([^"]+)"', text)
    assert len(anchors) == len(set(anchors))
    assert set(re.findall(r'href="#([^"]+)"', text)) <= set(anchors)
    assert text.count("<h1>") == 1
    assert f'href="{paper.PDF}"' in text


@pytest.mark.parametrize("width", [390, 1280])
def test_the_page_fits_the_screen_and_says_no_error(browser, page, width):
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    browser.get(page.as_uri())
    assert browser.get_log("browser") == []
    shown = "const all = document.documentElement; return [innerWidth, all.scrollWidth - all.clientWidth]"
    assert browser.execute_script(shown) == [width, 0]


def test_the_documentation_says_where_the_paper_is_or_how_it_is_made():
    assert "paper/index.html" in paper.link(True)
    assert "snakemake" in paper.link(False)
