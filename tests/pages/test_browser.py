"""Pages in a real browser: nothing is fetched or fails, nothing is wider than a phone, all can be read."""

import re

import pytest

import imugap as ig
from imugap.log import AXES

WIDTHS = (390, 1280)
CONTRAST = """
const channel = v => (v /= 255) <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
const light = c => 0.2126 * channel(c[0]) + 0.7152 * channel(c[1]) + 0.0722 * channel(c[2]);
const numbers = text => text.match(/[0-9.]+/g).map(Number);
const behind = one => {
  for (; one; one = one.parentElement) {
    const c = numbers(getComputedStyle(one).backgroundColor);
    if (c.length < 4 || c[3] > 0) return c;
  }
  return [255, 255, 255];
};
return Math.min(...[...document.querySelectorAll("main *")]
  .filter(one => !one.closest("svg") && [...one.childNodes].some(n => n.nodeType === 3 && n.textContent.trim()))
  .map(one => [light(numbers(getComputedStyle(one).color)), light(behind(one))])
  .map(([a, b]) => (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05)));
"""
"""Smallest contrast of a text to what is behind it (WCAG 2)."""


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages")
    model = {axis: [{"white_noise": {"density": 1e-3}}, {"random_walk": {"density_k": 1e-4}}] for axis in AXES}
    log = ig.simulate(model, 200, 20)
    dead = ig.read(log.table.assign(gyro_z=0.0))
    estimated = ig.estimate(log, axes=["gyro_x", "accel_z"], terms=["white_noise", "random_walk"])
    return [ig.check(dead).report(folder / "check"), estimated.report(folder / "estimate")]


@pytest.mark.parametrize("width", WIDTHS)
def test_a_page_fits_the_screen_and_says_no_error(browser, pages, width):
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    for page in pages:
        browser.get(page.as_uri())
        assert browser.get_log("browser") == []
        shown = "const all = document.documentElement; return [innerWidth, all.scrollWidth - all.clientWidth]"
        assert browser.execute_script(shown) == [width, 0]
        assert browser.execute_script("return performance.getEntriesByType('resource').length") == 0
        assert browser.execute_script(CONTRAST) > 4.5


def test_a_page_needs_no_other_file_and_every_picture_has_a_text(pages):
    for page in pages:
        text = page.read_text()
        assert not re.findall(r"(?:src|href)=\"(?!#|data:)", text)
        assert text.count("<svg") == len(re.findall(r'<svg role="img" aria-label="[^"]+"', text)) > 0
        names = re.findall(r'\bid="([^"]+)"', text)
        assert len(names) == len(set(names))
        assert text.count("<h1>") == 1
