"""Provenance Run Crate (profile 0.5) of a run of the workflow: which job made which file from which, and when.

The crate is the folder of the project: its metadata describe the files where they are.
"""

from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path

from rocrate.model.contextentity import ContextEntity
from rocrate.rocrate import ROCrate

from imugap.workflow.run_records import RunRecord

WORKFLOW = "workflow/Snakefile"
TYPES = ["File", "SoftwareSourceCode", "ComputationalWorkflow", "HowTo"]
"""What a workflow is that has steps."""
PROFILES = {
    "process/0.5": "Process Run Crate", "workflow/0.5": "Workflow Run Crate", "provenance/0.5": "Provenance Run Crate",
}  # fmt: skip
PROFILE_BASE = "https://w3id.org/ro/wfrun"
CONTEXT = "https://w3id.org/ro/terms/workflow-run/context"
BLOCK_BYTES = 1 << 20

Job = tuple[RunRecord, list[str]]
"""Record of a job, and the paths of its outputs."""


def crate(records: Mapping[str, RunRecord], software: Mapping[str, object], version: str) -> ROCrate:
    """Return the crate of a run in the working folder; ValueError where there are no records.

    Parameters
    ----------
    records
        Record of each output that is to be described, by path.
    software
        Description of the software (CodeMeta).
    version
        Version of Snakemake.
    """
    if not records:
        raise ValueError("run: expected records of at least one job; found none (run the workflow first)")
    jobs = _jobs(records)
    found = ROCrate(version="1.1")
    _describe(found, software, max(one.end for one, _ in jobs))
    names = dict.fromkeys((*records, *(name for one, _ in jobs for name in one.inputs)))
    files = {name: _file(found, name) for name in names if name != WORKFLOW}
    main = found.add_workflow(
        WORKFLOW,
        WORKFLOW,
        main=True,
        lang="snakemake",
        lang_version=version,
        properties={"@type": TYPES, "name": software["name"]},
    )
    files[WORKFLOW] = main
    steps = _steps(found, main, jobs)
    controls = [_execution(found, number, job, steps, files) for number, job in enumerate(jobs)]
    made, used = set(records), {name for one, _ in jobs for name in one.inputs}
    run = found.add_action(
        main,
        "#run",
        [files[name] for name in names if name not in made],
        [files[name] for name in names if name in made - used],
        {"@type": "CreateAction", "name": "Run of the workflow"} | _times(min(one.begin for one, _ in jobs),
                                                                            max(one.end for one, _ in jobs)),
    )  # fmt: skip
    found.root_dataset.append_to("mentions", run)
    engine = {"@type": "SoftwareApplication", "name": f"Snakemake {version}", "softwareVersion": version}
    engine |= {"url": "https://snakemake.readthedocs.io"}
    found.add_action(
        found.add(ContextEntity(found, "#snakemake", properties=engine)),
        "#orchestration",
        controls,
        run,
        {"@type": "OrganizeAction", "name": f"Run of Snakemake {version}"},
    )
    return found


def _jobs(records: Mapping[str, RunRecord]) -> list[Job]:
    """Return the jobs in the order of their begin, each with its outputs."""
    jobs: dict[RunRecord, list[str]] = {}
    for path, one in records.items():
        jobs.setdefault(one, []).append(path)
    return sorted(jobs.items(), key=lambda job: (job[0].begin, job[1]))


def _describe(found: ROCrate, software: Mapping[str, object], end: float) -> None:
    """Set title, licence and authors of the crate, and the profiles that it conforms to."""
    root = found.root_dataset
    found.name = f"Run of {software['name']} {software['version']}"
    found.description = str(software["description"])
    found.license = found.add(_entity(found, str(software["license"]), "CreativeWork", "BSD-3-Clause"))
    authors: Iterable[Mapping[str, str]] = software["author"]  # type: ignore[assignment]
    root["author"] = [
        found.add(_entity(found, f"#author-{number}", one["@type"], one["name"])) for number, one in enumerate(authors)
    ]
    root["datePublished"] = _time(end)
    for path, name in PROFILES.items():
        profile = _entity(found, f"{PROFILE_BASE}/{path}", "CreativeWork", name)
        profile["version"] = path.partition("/")[2]
        root.append_to("conformsTo", found.add(profile))
    found.metadata.extra_contexts.append(CONTEXT)


def _entity(found: ROCrate, identifier: str, kind: str, name: str) -> ContextEntity:
    return ContextEntity(found, identifier, properties={"@type": kind, "name": name})


def _file(found: ROCrate, name: str):
    """Return a file with size and SHA-256, a folder, or what is no longer there."""
    path = Path(name)
    if path.is_dir():
        return found.add_dataset(name, name)
    if not path.is_file():
        return found.add(_entity(found, f"#{name}", "CreativeWork", name))
    return found.add_file(name, name, properties={"contentSize": str(path.stat().st_size), "sha256": _digest(path)})


def _digest(path: Path) -> str:
    digest = sha256()
    with path.open("rb") as handle:
        while block := handle.read(BLOCK_BYTES):
            digest.update(block)
    return digest.hexdigest()


def _steps(found: ROCrate, main, jobs: Sequence[Job]) -> dict[str, tuple]:
    """Add each rule as a tool and as a step of the workflow; return both by rule."""
    steps = {}
    for position, rule in enumerate(dict.fromkeys(one.rule for one, _ in jobs)):
        tool = found.add(_entity(found, f"#rule-{rule}", "SoftwareApplication", rule))
        step = _entity(found, f"#step-{rule}", "HowToStep", rule)
        step["position"] = str(position)
        step["workExample"] = tool
        main.append_to("hasPart", tool)
        main.append_to("step", found.add(step))
        steps[rule] = tool, step
    return steps


def _execution(found: ROCrate, number: int, job: Job, steps: Mapping[str, tuple], files: Mapping):
    """Add the execution of a job; return that of its step."""
    one, outputs = job
    tool, step = steps[one.rule]
    properties = {"@type": "CreateAction", "name": f"Job {number} of the rule {one.rule}"} | _times(one.begin, one.end)
    inputs, results = [files[name] for name in one.inputs], [files[name] for name in outputs]
    made = found.add_action(tool, f"#job-{number}", inputs, results, properties)
    control = {"@type": "ControlAction", "name": f"Step of job {number}"}
    return found.add_action(step, f"#control-{number}", made, None, control)


def _times(begin: float, end: float) -> dict[str, str]:
    return {"startTime": _time(begin), "endTime": _time(end)}


def _time(seconds: float) -> str:
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="seconds")
