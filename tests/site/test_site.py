"""The documentation as built, in a browser: nothing is fetched or fails, no page is wider than a phone."""

import re
from pathlib import Path

import pytest

SITE = Path(__file__).parents[2] / "results/site"
WIDTHS = (390, 1280)


@pytest.fixture(scope="module")
def pages():
    if not (SITE / "index.html").exists():
        pytest.skip("the documentation is not built (snakemake site)")
    return sorted(SITE.rglob("*.html"))


@pytest.mark.slow
@pytest.mark.parametrize("width", WIDTHS)
def test_no_page_is_wider_than_the_screen_or_says_an_error(browser, pages, width):
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    for page in pages:
        browser.get(page.as_uri())
        assert browser.get_log("browser") == [], page
        shown = "const all = document.documentElement; return all.scrollWidth - all.clientWidth"
        assert browser.execute_script(shown) == 0, page
        loaded = browser.execute_script("return performance.getEntriesByType('resource').map(one => one.name)")
        assert all(one.startswith(("file:", "data:")) for one in loaded), page


def test_every_picture_has_a_text(pages):
    for page in pages:
        for picture in re.findall(r"<img [^>]+>", page.read_text()):
            assert re.search(r'alt="[^"]+"', picture), (page, picture)
