DRIVES = config["drive"]["runs"]
DRIVE_PARTS = range(1, config["drive"]["parts"] + 1)


rule drive_runs:
    """Filter a part of the simulated drives under every scheme of quality control, clean and with gross errors."""
    input:
        recipe="data/drive.yaml",
    output:
        errors="results/drive/{part}/errors.parquet",
        verdicts="results/drive/{part}/verdicts.csv",
        recovery="results/drive/{part}/events.csv",
    log:
        "logs/drive_runs/{part}.log",
    wildcard_constraints:
        part=r"\d+",
    params:
        seed=config["seed"],
        runs=lambda wildcards: list(range(1, DRIVES + 1))[int(wildcards.part) - 1 :: len(DRIVE_PARTS)],
        parted=config["drive"]["parted_runs"],
        code=library("drive_runs"),
    script:
        "../scripts/drive_runs.py"


rule drive_scores:
    """Score the simulated drives: errors, rejections, recovery, and whether the gate and the bars hold."""
    input:
        errors=expand("results/drive/{part}/errors.parquet", part=DRIVE_PARTS),
        verdicts=expand("results/drive/{part}/verdicts.csv", part=DRIVE_PARTS),
        events=expand("results/drive/{part}/events.csv", part=DRIVE_PARTS),
    output:
        scores="results/drive/scores.csv",
        kinds="results/drive/kinds.csv",
        recovery="results/drive/recovery.csv",
    log:
        "logs/drive_scores.log",
    params:
        code=library("drive_scores"),
    script:
        "../scripts/drive_scores.py"


rule drive_page:
    """Draw and tabulate the simulated drives: one of them, all of them, what each part of the control is worth."""
    input:
        recipe="data/drive.yaml",
        scores="results/drive/scores.csv",
        kinds="results/drive/kinds.csv",
        recovery="results/drive/recovery.csv",
    output:
        map=figure("drive_map", "Drive", "one drive (figure)"),
        sensors=figure("drive_sensors", "Drive", "estimated sensor errors (figure)"),
        runs=figure("drive_schemes", "Drive", "all drives (figure)"),
        schemes=table("drive_schemes", "Drive", "schemes (table)", caption="drive_table"),
        kinds=table("drive_kinds", "Drive", "kinds of gross errors (table)"),
        numbers="paper/numbers/drive.json",
    log:
        "logs/drive_page.log",
    params:
        seed=config["seed"],
        runs=DRIVES,
        shown=config["drive"]["shown_run"],
        code=library("drive_page"),
    script:
        "../scripts/drive_page.py"


rule drive_hidden:
    """Name, from the innovations of simulated drives, the effect that the filter does not model, or none."""
    input:
        recipe="data/drive.yaml",
    output:
        names="results/drive/hidden.csv",
    log:
        "logs/drive_hidden.log",
    params:
        seed=config["seed"],
        runs=config["drive"]["hidden_runs"],
        alpha=config["drive"]["alpha"],
        code=library("drive_hidden"),
    script:
        "../scripts/drive_hidden.py"


rule drive_hidden_page:
    """Tabulate what the innovations named of what was hidden."""
    input:
        names="results/drive/hidden.csv",
        recipe="data/drive.yaml",
    output:
        table=table("drive_hidden", "Drive", "hidden effects (table)"),
        numbers="paper/numbers/drive_hidden.json",
    log:
        "logs/drive_hidden_page.log",
    params:
        code=library("drive_hidden_page"),
    script:
        "../scripts/drive_hidden_page.py"


PAPER["drive"] += [*rules.drive_page.output, *rules.drive_hidden_page.output]

if "rtklibexplorer_drive" in PRESENT:

    rule drive_car:
        """Put the recorded drive to the test: model of the rest, tuned model, outages, schemes of quality control."""
        input:
            log=raw_drive("rtklibexplorer_drive"),
            clock=raw_drive("rtklibexplorer_drive", "clock"),
            fixes=raw_drive("rtklibexplorer_drive", "fixes"),
            tables=["data/datasets.csv", "data/files.csv"],
            recipe="data/drive.yaml",
        output:
            tuning="results/drive_car/tuning.csv",
            models="results/drive_car/models.yaml",
            outages="results/drive_car/outages.parquet",
            schemes="results/drive_car/schemes.csv",
            errors="results/drive_car/errors.parquet",
        log:
            "logs/drive_car.log",
        params:
            seed=config["seed"],
            seeds=config["drive"]["real_seeds"],
            rest_s=config["drive"]["rest_s"]["car"],
            outages_s=config["drive"]["outages_s"]["car"],
            code=library("drive_car"),
        script:
            "../scripts/drive_car.py"

    rule drive_car_page:
        """Draw and tabulate the recorded drive: track, drift in outages, quality control."""
        input:
            tuning="results/drive_car/tuning.csv",
            models="results/drive_car/models.yaml",
            outages="results/drive_car/outages.parquet",
            schemes="results/drive_car/schemes.csv",
            errors="results/drive_car/errors.parquet",
        output:
            outages=figure("drive_outages", "Drive", "outages of the recorded drive (figure)"),
            track=figure("drive_car", "Drive", "recorded drive (figure)"),
            table=table("drive_car", "Drive", "recorded drive (table)", caption="drive_car_table"),
            numbers="paper/numbers/drive_car.json",
        log:
            "logs/drive_car_page.log",
        params:
            code=library("drive_car_page"),
        script:
            "../scripts/drive_car_page.py"

    PAPER["drive"] += rules.drive_car_page.output


if "thor_flight75" in PRESENT:

    rule drive_flight:
        """Put the recorded flight to the test, against the filter aboard; draw its attitude."""
        input:
            log=raw_drive("thor_flight75"),
            tables=["data/datasets.csv", "data/files.csv"],
            recipe="data/drive.yaml",
        output:
            figure=figure("drive_flight", "Drive", "recorded flight (figure)"),
            numbers="paper/numbers/drive_flight.json",
        log:
            "logs/drive_flight.log",
        params:
            rest_s=config["drive"]["rest_s"]["flight"],
            outages_s=config["drive"]["outages_s"]["flight"],
            code=library("drive_flight"),
        script:
            "../scripts/drive_flight.py"

    PAPER["drive"] += rules.drive_flight.output
