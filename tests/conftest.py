"""Set up every test process before anything imports NumPy or Numba, which read their settings once.

Compiled kernels are cached for all processes and later runs, those of different versions of the library apart (see
:func:`imugap.workflow.dependencies.digest`). Tests are spread over the cores by contiguous stretches of files, of which
an idle process takes over a part (``--dist worksteal``): fixtures of a module are made by few processes, and no process
ends long before the others. There linear algebra has one thread. Property tests draw the same examples every time, and
take the time that they take, for the first call of a kernel compiles and a machine may be busy.
"""

import os
import shutil
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

from imugap.workflow.dependencies import digest

ROOT = Path(__file__).parents[1]
os.environ.setdefault("NUMBA_CACHE_DIR", str(ROOT / ".snakemake" / "numba" / digest()))
if "PYTEST_XDIST_WORKER" in os.environ:
    for library in ("OMP", "OPENBLAS", "MKL", "NUMBA"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")

import pytest
import yaml
from hypothesis import HealthCheck, settings
from tests import strict_json

from imugap.io.catalogue import datasets
from imugap.io.json_schema import Draft202012Validator

patient = [HealthCheck.too_slow]
settings.register_profile("derandomised", derandomize=True, deadline=None, suppress_health_check=patient)
settings.load_profile("derandomised")


def pytest_addoption(parser):
    """Add the option of the whole proof."""
    parser.addoption("--every", action="store_true", help="run long tests too, and slow ones with all parameters")


def pytest_collection_modifyitems(config, items):
    """Leave out long tests, and slow ones after the first parameters of a test, unless each is a subject of its own."""
    if config.getoption("--every"):
        return
    kept, left_out, begun = [], [], set()
    for item in items:
        name = item.nodeid.partition("[")[0]
        again = name in begun and item.get_closest_marker("slow") and not item.get_closest_marker("each")
        (left_out if again or item.get_closest_marker("long") else kept).append(item)
        begun.add(name)
    items[:] = kept
    if left_out:
        config.hook.pytest_deselected(items=left_out)


@pytest.fixture(scope="session")
def sets():
    """The data sets of the study, by name."""
    return datasets.load(ROOT / "data", ROOT / "workflow" / "schemas")


@pytest.fixture(scope="session")
def mirror():
    """The folder of the real logs; skips a test that needs them where they are not."""
    folder = os.environ.get("IMUGAP_MIRROR")
    if not (folder and Path(folder).is_dir()):
        pytest.skip("IMUGAP_MIRROR names no folder of real logs")
    return folder


BROWSER_OPTIONS = (
    "headless", "no-sandbox", "disable-gpu", "disable-quic", "no-first-run", "disable-background-networking",
    "disable-component-update", "disable-sync",
)  # fmt: skip


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """A headless browser that logs what it says on its console; skips a test where there is none."""
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    from selenium.webdriver.chrome.service import Service

    binary, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if not (binary and driver):
        pytest.skip("no browser: chromium and chromedriver (Debian: chromium, chromium-driver) are not installed")
    options = webdriver.ChromeOptions()
    options.binary_location = binary
    for one in (*BROWSER_OPTIONS, f"user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(f"--{one}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    found = webdriver.Chrome(options=options, service=Service(driver))
    yield found
    found.quit()


@pytest.fixture(scope="session")
def lap():
    """A drive of one lap by the recipe of the study."""
    from imugap.simulation.drive import Drive

    return replace(Drive.read(ROOT / "data" / "drive.yaml"), laps=1)


@pytest.fixture(scope="session")
def assumptions(lap):
    """Assumptions of a filter that hold on the lap."""
    from imugap.navigation.drive.vehicle import DriveAssumptions

    return DriveAssumptions(lever_m=lap.receiver.lever_m, scale_std=lap.scale_std)


@pytest.fixture
def judge(monkeypatch):
    """A goodness of fit that finds every model good; gives the sentence that it says."""
    sentence = "Nothing speaks against the model"
    monkeypatch.setattr(
        "imugap.estimation.goodness_of_fit.of", lambda *_, **__: SimpleNamespace(verdict=f"{sentence}.", off=())
    )
    return sentence


@pytest.fixture
def validated():
    """Read what ``imugap estimate`` writes: JSON that has neither NaN nor Infinity and keeps its schema."""
    schema = yaml.safe_load((ROOT / "workflow/schemas/estimates.schema.yaml").read_text())

    def read(text):
        records = strict_json.loads(text)
        Draft202012Validator(schema).validate(records)
        return records

    return read
