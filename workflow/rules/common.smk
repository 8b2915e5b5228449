import os
import re
from collections import defaultdict
from itertools import chain
from pathlib import Path

import yaml
from imugap.io.catalogue.datasets import available, load, locate
from imugap.io.configuration import ConfigurationError, configure, read
from imugap.interchange.from_indices import CONTENDERS
from imugap.interchange.datasheet import TRUTHS
from imugap.interchange.devices.catalogue import model_file
from imugap.workflow import restart
from imugap.workflow.dependencies import digest, modules_of

# Held as long as this process runs.
RUNNING = restart.begin() if workflow.is_main_process else None

config.update(configure(config, "workflow/schemas/study.schema.yaml"))

if config["navigation"]["table_horizon_s"] not in config["navigation"]["horizons_s"]:
    raise ConfigurationError("navigation.table_horizon_s: expected one of horizons_s")

CATALOGUE = load("data", "workflow/schemas")
RAW = "data/raw"
MIRROR = os.environ.get("IMUGAP_MIRROR") or config["mirror"]
if MIRROR and set("{}") & set(MIRROR):
    raise ConfigurationError(f"mirror: expected a folder without braces in its name; found {MIRROR}")
# Files of the user, by the key of the configuration. They are parameters of the rules with their state, and no inputs:
# braces in the name of an input are a wildcard.
OWN_FILES = {
    option: [value] if isinstance(value, str) else value or []
    for option, value in config.items()
    if option in ("own_logs", "log", "test", "reference", "model")
}
OWN_FILES["model"] = [str(model_file(one)) for one in OWN_FILES["model"]]

for option, paths in OWN_FILES.items():
    for path in paths:
        if not Path(path).is_file():
            hint = " (in a list, put a name with braces, brackets or commas in quotes)" if path[:1] == "[" else ""
            raise ConfigurationError(f"{option}: expected a file; found none at {path}{hint}")

PRESENT = [name for name in CATALOGUE if available(CATALOGUE[name], RAW, MIRROR)]
RUNS = {
    "bench": config["devices"]["bench"],
    "adis16405": config["devices"]["adis16405"] if "adis16405" in PRESENT else [],
    "own": list(range(1, len(OWN_FILES["own_logs"]) + 1)),
}
DEVICES = [device for device, runs in RUNS.items() if runs]
POWER_CYCLES = config["power_cycles"] if "memsense_turnon" in PRESENT else []
TRIALS = config["attitude"]["trials"] if "broad" in PRESENT else []
# The runs of whatever has its logs ingested, by device: one job reads all of a device.
LOGS = RUNS | {"memsense_turnon": POWER_CYCLES, "broad": TRIALS}
LOGS = {device: runs for device, runs in LOGS.items() if runs}
WALKS = [name for name in PRESENT if CATALOGUE[name].kind == "walk"]
# The trials of the published protocol: a set of walks and the one that continues it.
PROTOCOL = ["pyshoe_vicon", "pyshoe_vicon_rest"]
PROTOCOL = PROTOCOL if set(PROTOCOL) <= set(PRESENT) else []
SITES = config["sites"] | {"bench": yaml.safe_load(Path("data/bench.yaml").read_text())["site"]}
OMITTED = [name for name in CATALOGUE if name not in PRESENT]
NOTEBOOK_OF = {
    "static": "study",
    "estimation": "estimation",
    "discovery": "discovery",
    "walk": "pedestrian",
    "drive": "drive",
}
CHAPTERS = ["study", *config["chapters"]]
NOTEBOOKS = [name for name, chapter in NOTEBOOK_OF.items() if chapter in CHAPTERS]
# The products that the chapters of the paper show, "study" those that it always has: the rules add theirs.
PAPER = defaultdict(list)
# What the target discover works on.
OPTIONS = {option: paths for option, paths in OWN_FILES.items() if option != "own_logs"}

for option, paths in OPTIONS.items():
    if paths and not OPTIONS["log"]:
        raise ConfigurationError(f"log: expected the log that {option} belongs to; found none")

# Inputs of each discovery, by the folder of its products below results.
DISCOVERIES = {"story/hidden": {"log": ["results/story/cases/hidden/log.parquet"]}}
# Trials in motion for discovery, with the error-free log of the cameras.
SIGHTED = [run for run in TRIALS if run in config["discovery"]["trials"] and "discovery" in CHAPTERS]
# Settings of every discovery.
DISCOVERY_SETTINGS = {key: config["discovery"][key] for key in ("alpha", "replicates", "simulations")}
TRIAL_CASES = {name: config["trials"][name]["cases"] for name in ("forecasts", "curves")}
STARTS = ["white", "nbk"]
# Devices for discovery: on the first run, from two start models, tested on the other runs.
MISSING_OF = [name for name in config["discovery"]["devices"] if len(RUNS[name]) > 1 and "discovery" in CHAPTERS]
# Devices whose runs are left out in turn: real ones.
UNSEEN_OF = [name for name in MISSING_OF if name != "bench"]
for name in MISSING_OF:
    first, *others = (f"results/{name}/{run}" for run in RUNS[name])
    runs = {
        "log": [f"{first}/means.parquet"],
        "test": [f"{one}/means.parquet" for one in others],
    }
    DISCOVERIES[f"missing/{name}_white"] = runs
    DISCOVERIES[f"missing/{name}_nbk"] = runs | {"model": [f"{first}/nbk.yaml"]}
    DISCOVERIES[f"missing/{name}_runs"] = {"log": [*runs["log"], *runs["test"]]}
DISCOVERIES |= {
    f"motion/broad_{run}": {
        "log": [f"results/broad/{run}/sighted/log.parquet"],
        "reference": [f"results/broad/{run}/sighted/ideal.parquet"],
    }
    for run in SIGHTED
}
# Recordings of devices that took no part in building the method, searched like any other log.
RECIPES = read("data/recordings.yaml", "workflow/schemas/recordings.schema.yaml")
RECORDINGS = [
    name
    for name in config["discovery"]["recordings"]
    if RECIPES[name]["dataset"] in PRESENT and "discovery" in CHAPTERS
]
REFERENCED = [name for name in RECORDINGS if "reference" in RECIPES[name]]

for name, recipe in RECIPES.items():
    DISCOVERIES[f"recordings/{name}"] = {"log": [f"results/recordings/{name}/log.parquet"]}
    if "reference" in recipe:
        DISCOVERIES[f"recordings/{name}"]["reference"] = [f"results/recordings/{name}/reference.parquet"]

# Devices of which a model is shipped with the library: those that have their logs here.
DEVICE_RECIPES = read("data/devices.yaml", "workflow/schemas/devices.schema.yaml")
DEVICE_MODELS = {
    name: recipe
    for name, recipe in DEVICE_RECIPES.items()
    if (RECIPES[recipe["recording"]]["dataset"] in PRESENT if "recording" in recipe else recipe["dataset"] in LOGS)
}

for name, recipe in DEVICE_MODELS.items():
    if "dataset" in recipe:
        logs = [f"results/{recipe['dataset']}/{run}/log.parquet" for run in LOGS[recipe["dataset"]]]
        DISCOVERIES[f"devices/{name}"] = {"log": logs}

# The folder of one's own discovery has the name of the log, with _ for what a wildcard cannot hold.
OWN_DISCOVERY = None
if OPTIONS["log"]:
    stem = re.sub(r"[^\w.-]+", "_", Path(OPTIONS["log"][0]).stem)
    OWN_DISCOVERY = f"discover/{stem}"
    own = {"effects": config["effects"]} if config["effects"] else {}
    DISCOVERIES[OWN_DISCOVERY] = OPTIONS | own


# Jobs of minutes, and those that they wait for, have priority 1: else one of them runs last, beside an idle core.
wildcard_constraints:
    device="bench|adis16405|own|memsense_turnon|broad",
    dataset="|".join(CATALOGUE),
    run=r"\d+",
    contender="|".join(CONTENDERS),


os.environ.setdefault("NUMBA_CACHE_DIR", str(Path(".snakemake/numba", digest()).absolute()))


def library(script):
    """Give a digest of the modules of the library and of the benchmark that a script runs, so that their change reruns its rule.

    As inputs, the files would be looked up for every waiting job whenever a job starts or ends.
    """
    return digest(modules_of(f"workflow/scripts/{script}.py", "src/imugap", "benchmark/src/imu_benchmark"))


def figure(name, category, result, caption=None, **labels):
    """Name the file of a figure, which the report shows; its caption has the name of the figure without the device."""
    return shown(f"paper/figures/{name}.svg", category, result, caption, labels)


def table(name, category=None, result=None, caption=None, **labels):
    """Name the files of a table: CSV, which the report shows where there is a category, JSON and LaTeX."""
    data, *others = multiext(f"paper/tables/{name}", ".csv", ".json", ".tex")
    return [shown(data, category, result, caption, labels) if category else data, *others]


def shown(path, category, result, caption, labels):
    """Mark a file for the report."""
    caption = caption or Path(path).stem.removesuffix("_{device}")
    labels = {"result": result} | labels
    return report(path, caption=f"../report/{caption}.rst", category=category, labels=labels)


def of_devices(rule):
    """Name the outputs of a rule for every device of the study."""
    return expand(rule.output, device=DEVICES)


def per_run(device, name):
    """Name the file ``name`` of every run of one device."""
    return expand(f"results/{device}/{{run}}/{name}", run=LOGS[device])


def of_runs(name):
    """Name the file ``name`` of every run of the device."""
    return lambda wildcards: per_run(wildcards.device, name)


def of_trials(name):
    """Name the file ``name`` of every trial."""
    return per_run("broad", name)


def raw_logs(device):
    """Name the raw logs of a device: generated, given by the user, or of the catalogue (fetched or in the mirror)."""
    if device == "bench":
        return expand(f"{RAW}/bench/run{{run}}.parquet", run=RUNS["bench"])
    if device == "own":
        return OWN_FILES["own_logs"]
    files = (CATALOGUE[device].file(run) for run in LOGS[device])
    return [str(locate(file, RAW, MIRROR)) for file in files]


def raw_drive(name, content="log"):
    """Name the raw file of a recorded drive."""
    return str(locate(CATALOGUE[name].file(1, content), RAW, MIRROR))


def twins_of(wildcards):
    """Name the file of the twins of a set of walks; the embedded walks need none."""
    if wildcards.walkers == "embedded":
        return {}
    return {"twins": f"results/walk/real/{wildcards.walkers}.json"}


def site(wildcards):
    """Give the site of a device: where it stood and, if known, its heading."""
    return SITES[wildcards.device]


def assumptions(site, motion):
    """Give what the filter takes for granted besides the error model."""
    return {
        "site": site,
        "memory_s": config["attitude"]["acceleration_s"][motion],
        "bias_std": config["attitude"]["bias_std"],
    }


def states(paths):
    """Give the size and the time of change of files of the user, which rerun the rules that read them."""
    return [(status.st_size, status.st_mtime_ns) for status in map(os.stat, paths)]


def recording_file(content):
    """Name the raw file with ``content`` of the recording."""

    def path(wildcards):
        recipe = RECIPES[wildcards.recording]
        return str(locate(CATALOGUE[recipe["dataset"]].file(recipe["run"], content), RAW, MIRROR))

    return path


def device_discovery(name):
    """Name the discovery that the model of a device is made of."""
    recipe = DEVICE_MODELS[name]
    return f"recordings/{recipe['recording']}" if "recording" in recipe else f"devices/{name}"


def device_data(name):
    """Give the data set and the runs that the model of a device is found on."""
    recipe = DEVICE_MODELS[name]
    if "recording" in recipe:
        own = RECIPES[recipe["recording"]]
        return own["dataset"], [own["run"]]
    return recipe["dataset"], LOGS[recipe["dataset"]]


def discovery_files(wildcards):
    """Name the files of a discovery by their options."""
    given = DISCOVERIES[wildcards.discovery]
    return {option: given.get(option, []) for option in OPTIONS}


def discovery_inputs(wildcards):
    """Name the files of a discovery that the workflow makes."""
    return [] if wildcards.discovery == OWN_DISCOVERY else list(chain(*discovery_files(wildcards).values()))


def discovery_states(wildcards):
    """Give the states of the files of a discovery that the user gives."""
    return states(chain(*OPTIONS.values())) if wildcards.discovery == OWN_DISCOVERY else []


def own_effects(wildcards):
    """Name the file of the module of one's own effects, if it lies here."""
    path = f"{DISCOVERIES[wildcards.discovery].get('effects', '').replace('.', '/')}.py"
    return [path] if Path(path).is_file() else []


def made_or_recorded(run, names):
    """Name the tables of a run made here, below results; of one named NAME_recorded those in data, with its record."""
    if not run.endswith("_recorded"):
        return {name: f"results/{run}/{name}.csv" for name in names}
    return {name: f"data/{run}/{name}.csv" for name in names} | {"record": f"data/{run}/record.yaml"}


def blind_scores(wildcards):
    """Name the scores of the blind benchmark case by case: of its run here, or of the recorded one with its record."""
    return made_or_recorded(wildcards.benchmark, ("cases", "effects", "parameters", "p_values", "run_time"))


def baseline_scores(wildcards):
    """Name the scores of the baselines: of their run here, or of the recorded one with its record."""
    return made_or_recorded(wildcards.baselines, ("summary", "answers"))


def trial_batches(trial):
    """Name the batches of the cases of a trial: the numbers of their first ones."""
    return [str(first) for first in range(0, TRIAL_CASES[trial], config["trials"]["cases_per_job"])]


def trial_tables(wildcards):
    """Name the tables of the trials: of their run here, or of the recorded one with its record."""
    return made_or_recorded(wildcards.trials, TRIAL_CASES)


def ablation_tables(wildcards):
    """Name the comparisons of names with wrong names: of their run here, or of the recorded one with its record."""
    return made_or_recorded(wildcards.ablation, ["comparisons"])


def injection_tables(wildcards):
    """Name the trials of effects in real logs: of their run here, or of the recorded one with its record."""
    return made_or_recorded(wildcards.injection, ["trials"])


def dossier_of_log(wildcards):
    """Name the page of what is found on the log of the configuration."""
    if not OWN_DISCOVERY:
        raise ConfigurationError("log: expected --config log=PATH; found none")
    return f"results/{OWN_DISCOVERY}/report.md"
