from pathlib import Path
from shutil import copytree

import pytest

from imugap.workflow.dependencies import PACKAGE, digest, modules_of

SCRIPTS = Path(__file__).parents[2] / "workflow" / "scripts"
BENCHMARK = Path(__file__).parents[2] / "benchmark" / "src" / "imu_benchmark"
SOURCES = {
    "__init__.py": "",
    "alone.py": "import os\n",
    "first.py": "from lib.second import thing\n",
    "second.py": "import lib.third\n",
    "third.py": "from lib import first\n",  # a circle
    "deep/__init__.py": "from lib.deep.inner import x\n",
    "deep/inner.py": "import numpy\n",
    "deep/other.py": "",
    "late.py": "def f():\n    from lib import alone\n",
}


@pytest.fixture
def package(tmp_path):
    for name, text in SOURCES.items():
        path = tmp_path / "lib" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path / "lib"


def found(package, text):
    script = package.parent / "script.py"
    script.write_text(text)
    return [str(path.relative_to(package)) for path in modules_of(script, package)]


@pytest.mark.parametrize(
    ("text", "modules"),
    [
        ("import numpy\nimport os.path\n", []),
        ("import library\nfrom libs import alone\n", []),
        ("import lib\n", ["__init__.py"]),
        ("from lib.alone import os\n", ["__init__.py", "alone.py"]),
        ("from lib import alone as a, nothing\n", ["__init__.py", "alone.py"]),
        ("import lib.first\n", ["__init__.py", "first.py", "second.py", "third.py"]),
        ("from lib import third\n", ["__init__.py", "first.py", "second.py", "third.py"]),
        ("import lib.deep\n", ["__init__.py", "deep/__init__.py", "deep/inner.py"]),
        ("from lib.deep import other\n", ["__init__.py", "deep/__init__.py", "deep/inner.py", "deep/other.py"]),
        ("def main():\n    import lib.late\n", ["__init__.py", "alone.py", "late.py"]),
        ("text = 'import lib.first'  # import lib.first\n", []),
    ],
)
def test_a_script_runs_what_it_imports_directly_or_not(package, text, modules):
    assert found(package, text) == modules


@pytest.mark.parametrize("statement", ["from . import alone", "from .alone import os", "from ..lib import alone"])
def test_relative_imports_are_refused_with_their_line(package, statement):
    (package / "late.py").write_text(f"import os\n{statement}\n")
    with pytest.raises(ValueError, match=r"late\.py, line 2: expected an absolute import"):
        found(package, "import lib.late\n")


def names(script):
    return {str(path.relative_to(PACKAGE)) for path in modules_of(SCRIPTS / f"{script}.py")}


def test_the_audit_script_depends_on_what_the_audit_runs():
    run = {"study/static/he2023.py", "units.py", "kinematics/strapdown.py", "kinematics/earth.py", "workflow/tables.py"}
    assert {"__init__.py", *run} <= names("audit")
    assert not {"integrity/sampling_clock.py", "estimation/variances/allan.py", "io/configuration.py"} & names("audit")


def test_the_script_that_fits_models_depends_on_every_effect():
    effects = {f"effects/{path.name}" for path in (PACKAGE / "effects").glob("*.py")}
    assert effects <= names("fit_models")
    assert "study/static/he2023.py" not in names("fit_models")


@pytest.mark.parametrize("script", sorted(SCRIPTS.glob("*.py")), ids=lambda path: path.stem)
def test_every_script_depends_on_files_that_exist_each_once_and_sorted(script):
    modules = modules_of(script)
    assert all(path.is_file() for path in modules)
    assert modules == sorted(set(modules))


def test_the_digest_changes_with_any_of_its_modules_and_with_nothing_else(package):
    modules = sorted(package.rglob("*.py"))
    before = digest(modules)
    (package.parent / "beside.py").write_text("new")
    assert digest(reversed(modules)) == before
    (package / "deep" / "inner.py").write_text("import numpy as np\n")
    assert digest(modules) != before


def test_the_digest_is_that_of_the_sources_wherever_they_are(package, tmp_path):
    elsewhere = copytree(package, tmp_path / "elsewhere" / "lib")
    assert digest(elsewhere.rglob("*.py")) == digest(package.rglob("*.py"))
    assert digest() == digest(PACKAGE.rglob("*.py")) != digest(package.rglob("*.py"))


def test_a_script_depends_on_the_modules_of_several_packages(package):
    other = package.parent / "more"
    other.mkdir()
    (other / "__init__.py").write_text("from lib import alone\n")
    script = package.parent / "script.py"
    script.write_text("import more\n")
    expected = [package / "__init__.py", package / "alone.py", other / "__init__.py"]
    assert modules_of(script, package, other) == expected
    assert modules_of(script, package) == []
    assert BENCHMARK / "sealing/case.py" in modules_of(SCRIPTS / "blind_seal.py", PACKAGE, BENCHMARK)


def test_no_module_uses_relative_imports():
    """What modules_of does not see must not be there."""
    paths = [*PACKAGE.rglob("*.py"), *BENCHMARK.rglob("*.py")]
    assert not [path for path in paths if "\nfrom ." in path.read_text()]


def test_the_answer_is_relative_where_the_package_is(monkeypatch):
    monkeypatch.chdir(SCRIPTS.parents[1])
    assert Path("src/imugap/study/static/he2023.py") in modules_of("workflow/scripts/audit.py", "src/imugap")
