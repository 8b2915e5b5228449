rule walk_models:
    """Calibrate the device of the simulated walk at rest, and build every contender from its logs."""
    input:
        recipe="data/walk.yaml",
    output:
        models="results/walk/models.yaml",
        indices="results/walk/indices.csv",
    log:
        "logs/walk_models.log",
    params:
        seed=config["seed"],
        static=config["walks"]["static"],
        period_s=config["bias_stability_period_s"],
        rate_hz=config["estimation"]["rate_hz"],
        code=library("walk_models"),
    script:
        "../scripts/walk_models.py"


rule walk_subtracted:
    """Subtract what each model simulates from the log of the walk, ahead of the navigator (figure 5 of the source)."""
    input:
        recipe="data/walk.yaml",
        models="results/walk/models.yaml",
        indices="results/walk/indices.csv",
    output:
        ends="results/walk/subtracted.parquet",
        tracks="results/walk/tracks.parquet",
    log:
        "logs/walk_subtracted.log",
    params:
        seed=config["seed"],
        devices=config["walks"]["devices"],
        printed=config["walks"]["printed_trials"],
        code=library("walk_subtracted"),
    script:
        "../scripts/walk_subtracted.py"


rule walk_inside:
    """Navigate the walk with a filter that holds the states and densities of each model."""
    input:
        recipe="data/walk.yaml",
        models="results/walk/models.yaml",
    output:
        ends="results/walk/inside.parquet",
    log:
        "logs/walk_inside.log",
    params:
        seed=config["seed"],
        devices=config["walks"]["devices"],
        code=library("walk_inside"),
    script:
        "../scripts/walk_inside.py"


rule compensation_page:
    """Draw and tabulate what compensation is worth (figures 4 and 6, table 3 of the source), with the verdict."""
    input:
        recipe="data/walk.yaml",
        ends="results/walk/subtracted.parquet",
        tracks="results/walk/tracks.parquet",
        inside="results/walk/inside.parquet",
        printed="data/published/he2023_table3_pedestrian_compensation.csv",
    output:
        tracks=figure("compensation_tracks", "Walks", "compensated walks (figure)"),
        ends=figure("compensation_ends", "Walks", "end errors over devices (figure)"),
        table=table("compensation", "Walks", "compensation (table)"),
        inside=table("compensation_inside", "Walks", "models inside the filter (table)"),
        numbers="paper/numbers/compensation.json",
    log:
        "logs/compensation_page.log",
    params:
        seed=config["seed"],
        code=library("compensation_page"),
    script:
        "../scripts/compensation_page.py"


rule walk_real:
    """Navigate every walk of a data set, and lay it over what cameras saw."""
    input:
        raw=lambda wildcards: [str(locate(file, RAW, MIRROR)) for file in CATALOGUE[wildcards.dataset].files],
        recipe="data/walk.yaml",
        tables=["data/datasets.csv", "data/files.csv"],
    output:
        walks="results/walk/real/{dataset}.csv",
        tracks="results/walk/real/{dataset}.parquet",
        twins="results/walk/real/{dataset}.json",
    log:
        "logs/walk_real/{dataset}.log",
    params:
        code=library("walk_real"),
    script:
        "../scripts/walk_real.py"


rule walk_real_page:
    """Draw and tabulate the real walks beside what peers make of them."""
    input:
        walks=expand("results/walk/real/{dataset}.csv", dataset=WALKS),
        tracks=expand("results/walk/real/{dataset}.parquet", dataset=WALKS),
        peers="data/published/walk_peers.csv",
    output:
        walks=figure("walks", "Walks", "real walks (figure)"),
        errors=figure("walk_errors", "Walks", "errors against cameras (figure)"),
        table=table("walks", "Walks", "real walks (table)", caption="walks_table"),
        sets=table("walks_sets"),
        peers=table("walks_peers", "Walks", "what peers make of the walks (table)"),
        numbers="paper/numbers/walks.json",
    log:
        "logs/walk_real_page.log",
    params:
        code=library("walk_real_page"),
    script:
        "../scripts/walk_real_page.py"


rule walk_protocol:
    """Navigate the trials of PyShoe with several settings, and score them by the published protocol."""
    input:
        **{name: [str(locate(file, RAW, MIRROR)) for file in CATALOGUE[name].files] for name in PROTOCOL},
        tables=["data/datasets.csv", "data/files.csv"],
    output:
        scores="results/walk/protocol.csv",
    log:
        "logs/walk_protocol.log",
    params:
        sets=PROTOCOL,
        trials=config["walks"]["protocol_trials"],
        factors=[0.5, 2],
        code=library("walk_protocol"),
    script:
        "../scripts/walk_protocol.py"


rule walk_protocol_page:
    """Tabulate the trials of PyShoe by the published protocol, beside the published figures."""
    input:
        scores="results/walk/protocol.csv",
        published="data/published/pyshoe_protocol.csv",
    output:
        table=table("walk_protocol", "Walks", "the published protocol (table)"),
        numbers="paper/numbers/walk_protocol.json",
    log:
        "logs/walk_protocol_page.log",
    params:
        seed=config["seed"],
        code=library("walk_protocol_page"),
    script:
        "../scripts/walk_protocol_page.py"


rule walk_budget:
    """Navigate the twins of the walks of a set, or the embedded walks, without one error of the device at a time."""
    input:
        unpack(twins_of),
        recipe="data/walk.yaml",
        kind="data/foot.yaml",
    output:
        errors="results/walk/budget/{walkers}.parquet",
    log:
        "logs/walk_budget/{walkers}.log",
    wildcard_constraints:
        walkers="|".join(["embedded", *CATALOGUE]),
    params:
        seed=config["seed"],
        draws=config["walks"]["draws"],
        code=library("walk_budget"),
    script:
        "../scripts/walk_budget.py"


rule walk_sensitivity:
    """Navigate the walks of a set with other thresholds and detectors, and with delayed accelerometers."""
    input:
        raw=lambda wildcards: [str(locate(file, RAW, MIRROR)) for file in CATALOGUE[wildcards.dataset].files],
        tables=["data/datasets.csv", "data/files.csv"],
    output:
        choices="results/walk/choices/{dataset}.csv",
    log:
        "logs/walk_sensitivity/{dataset}.log",
    params:
        factors=[0.25, 0.5, 0.71, 1, 1.41, 2, 4],
        doubts=[0.5, 2],
        delays_ms=[-4, -2, 0, 2, 4],
        code=library("walk_sensitivity"),
    script:
        "../scripts/walk_sensitivity.py"


rule walk_consistency:
    """Count how often the ellipse of the end holds the true one, over simulated loops."""
    input:
        recipe="data/walk.yaml",
    output:
        ends="results/walk/consistency.csv",
    log:
        "logs/walk_consistency.log",
    params:
        seed=config["seed"],
        walks=config["walks"]["loops"],
        strides=config["walks"]["loop_strides"],
        code=library("walk_consistency"),
    script:
        "../scripts/walk_consistency.py"


rule walk_limits_page:
    """Draw and tabulate what limits a walk: errors one at a time, the detector, and whether the filter knows."""
    input:
        budgets=expand("results/walk/budget/{walkers}.parquet", walkers=["embedded", *WALKS]),
        choices=expand("results/walk/choices/{dataset}.csv", dataset=WALKS),
        walks=expand("results/walk/real/{dataset}.csv", dataset=WALKS),
        consistency="results/walk/consistency.csv",
    output:
        budget_figure=figure("walk_budget", "Walks", "which error dominates (figure)"),
        sensitivity=figure("walk_sensitivity", "Walks", "thresholds and detectors (figure)"),
        budget=table("walk_budget", "Walks", "which error dominates (table)"),
        consistency=table("walk_consistency", "Walks", "ellipses of the end (table)"),
        settings=table("walk_settings", "Walks", "settings chosen on other sets (table)"),
        numbers="paper/numbers/walk_limits.json",
    log:
        "logs/walk_limits_page.log",
    params:
        seed=config["seed"],
        code=library("walk_limits_page"),
    script:
        "../scripts/walk_limits_page.py"


rule walk_hidden:
    """Hide one effect at a time in a simulated loop; test discovery with the exact reference, and zero velocity without."""
    input:
        recipe="data/walk.yaml",
        cases="data/hidden.yaml",
    output:
        expand("results/walk/hidden/{case}.csv", case=config["walks"]["hidden"]),
    log:
        "logs/walk_hidden.log",
    priority: 1
    params:
        cases=config["walks"]["hidden"],
        seed=config["seed"],
        strides=config["walks"]["loop_strides"],
        settings=DISCOVERY_SETTINGS,
        code=library("walk_hidden"),
    script:
        "../scripts/walk_hidden.py"


rule walk_hidden_page:
    """Tabulate what is found of the effects that were hidden in simulated walks."""
    input:
        cases="data/hidden.yaml",
        found=expand("results/walk/hidden/{case}.csv", case=config["walks"]["hidden"]),
    output:
        table=table("walk_hidden", "Walks", "discovery on walks (table)"),
        numbers="paper/numbers/walk_hidden.json",
    log:
        "logs/walk_hidden_page.log",
    params:
        cases=config["walks"]["hidden"],
        code=library("walk_hidden_page"),
    script:
        "../scripts/walk_hidden_page.py"


rule walk_missing:
    """Find the effects that the twin of the real walks lacks; predict with them the ends of the other walks."""
    input:
        **{name: [str(locate(file, RAW, MIRROR)) for file in CATALOGUE[name].files] for name in WALKS},
        recipe="data/walk.yaml",
        kind="data/foot.yaml",
        tables=["data/datasets.csv", "data/files.csv"],
    output:
        found="results/walk/missing/found.csv",
        ends="results/walk/missing/ends.parquet",
    log:
        "logs/walk_missing.log",
    params:
        sets=WALKS,
        seed=config["seed"],
        alpha=config["discovery"]["alpha"],
        halves=config["walks"]["halves"],
        draws=config["walks"]["replays"],
        code=library("walk_missing"),
    script:
        "../scripts/walk_missing.py"


rule walk_missing_page:
    """Draw and tabulate what the twins of the real walks lack, and how well they foretell the ends of others."""
    input:
        found="results/walk/missing/found.csv",
        ends="results/walk/missing/ends.parquet",
    output:
        figure=figure("walk_foretold", "Walks", "ends foretold by twins (figure)"),
        found=table("walk_missing", "Walks", "discovery on real walks (table)"),
        scores=table("walk_foretold", "Walks", "ends foretold by twins (table)"),
        numbers="paper/numbers/walk_missing.json",
    log:
        "logs/walk_missing_page.log",
    params:
        seed=config["seed"],
        code=library("walk_missing_page"),
    script:
        "../scripts/walk_missing_page.py"


PAPER["pedestrian"] += [*rules.walk_hidden_page.output, *rules.compensation_page.output]
PAPER["pedestrian"] += rules.walk_limits_page.output
PAPER["pedestrian"] += rules.walk_protocol_page.output if PROTOCOL else []
PAPER["pedestrian"] += [*rules.walk_real_page.output, *rules.walk_missing_page.output] if WALKS else []
