"""Provenance Run Crate: what its profile demands, on a run of three jobs."""

import json
from hashlib import sha256
from pathlib import Path

import pytest

pytest.importorskip("rocrate")
from rocrate.rocrate import ROCrate

from imugap.workflow.run_crate import WORKFLOW, crate
from imugap.workflow.run_records import RunRecord

ROOT = Path(__file__).parents[2]
SOFTWARE = json.loads((ROOT / "codemeta.json").read_text())
DRAWN = RunRecord("draw", ("results/a.csv", "results/b.csv"), (), 150.0, 155.0)
RECORDS = {
    "results/a.csv": RunRecord("count", ("data.yaml",), (), 100.0, 130.0),
    "results/b.csv": RunRecord("count", ("data.yaml",), (), 110.0, 140.0),
    "paper/figure.svg": DRAWN,
    "paper/table.csv": DRAWN,
}


@pytest.fixture
def graph(tmp_path, monkeypatch):
    """Entities of the crate by identifier, read again by the library."""
    monkeypatch.chdir(tmp_path)
    for name in ("data.yaml", WORKFLOW, *RECORDS):
        Path(name).parent.mkdir(exist_ok=True)
        Path(name).write_text(name)
    metadata = crate(RECORDS, SOFTWARE, "9.0").metadata.generate()
    Path("ro-crate-metadata.json").write_text(json.dumps(metadata))
    assert ROCrate(".").mainEntity.id == WORKFLOW
    return {one["@id"]: one for one in metadata["@graph"]}


def ids(value):
    """Return the identifiers of one reference, or of several."""
    return {one["@id"] for one in (value if isinstance(value, list) else [value])}


def references(value):
    if isinstance(value, dict):
        return {value["@id"]} if set(value) == {"@id"} else set().union(*map(references, value.values()))
    return set().union(*map(references, value)) if isinstance(value, list) else set()


def test_every_reference_is_described_or_an_address(graph):
    used = set().union(*map(references, graph.values()))
    assert {one for one in used - set(graph) if not one.startswith("https://")} == set()


def test_the_profiles_are_those_of_a_provenance_run_crate(graph):
    assert {f"https://w3id.org/ro/wfrun/{one}/0.5" for one in ("process", "workflow", "provenance")} <= ids(
        graph["./"]["conformsTo"]
    )
    assert ids(graph["./"]["mentions"]) == {"#run"}
    assert {"name", "description", "license", "datePublished", "author"} <= graph["./"].keys()


def test_the_workflow_has_its_tools_and_steps(graph):
    main = graph[WORKFLOW]
    assert set(main["@type"]) == {"File", "SoftwareSourceCode", "ComputationalWorkflow", "HowTo"}
    assert ids(main["hasPart"]) == {"#rule-count", "#rule-draw"}
    for step in ids(main["step"]):
        assert ids(graph[step]["workExample"]) <= ids(main["hasPart"])


def test_every_job_is_an_execution_of_its_tool_under_the_control_of_its_step(graph):
    jobs = {name: one for name, one in graph.items() if name.startswith("#job-")}
    assert len(jobs) == 3
    controls = {name: one for name, one in graph.items() if one["@type"] == "ControlAction"}
    assert set().union(*(ids(one["object"]) for one in controls.values())) == set(jobs)
    (drawn,) = (one for one in jobs.values() if ids(one["instrument"]) == {"#rule-draw"})
    assert ids(drawn["object"]) == {"results/a.csv", "results/b.csv"}
    assert ids(drawn["result"]) == {"paper/figure.svg", "paper/table.csv"}
    assert drawn["startTime"] == "1970-01-01T00:02:30+00:00"
    assert ids(graph["#orchestration"]["object"]) == set(controls)
    assert ids(graph["#orchestration"]["result"]) == {"#run"}


def test_the_run_takes_what_no_job_makes_and_gives_what_no_job_takes(graph):
    assert ids(graph["#run"]["object"]) == {"data.yaml"}
    assert ids(graph["#run"]["result"]) == {"paper/figure.svg", "paper/table.csv"}
    assert graph["data.yaml"]["sha256"] == sha256(b"data.yaml").hexdigest()


def test_without_a_run_there_is_none():
    with pytest.raises(ValueError, match="expected records of at least one job"):
        crate({}, SOFTWARE, "9.0")
