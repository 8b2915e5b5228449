rule recording_log:
    """Read a recording as the file of a user, cut it to its stretch, and say what is wrong with it."""
    input:
        raw=recording_file("log"),
        tables=["data/datasets.csv", "data/files.csv"],
    output:
        log="results/recordings/{recording}/log.parquet",
        properties="results/recordings/{recording}/properties.json",
    log:
        "logs/recording_log/{recording}.log",
    priority: 1
    params:
        recipe=lambda wildcards: RECIPES[wildcards.recording],
        code=library("recording_log"),
    script:
        "../scripts/recording_log.py"


rule recording_reference:
    """Build the error-free log of a recording from its poses, and read the biases that their publisher estimated."""
    input:
        log="results/recordings/{recording}/log.parquet",
        poses=recording_file("poses"),
    output:
        reference="results/recordings/{recording}/reference.parquet",
        biases="results/recordings/{recording}/biases.csv",
    log:
        "logs/recording_reference/{recording}.log",
    priority: 1
    params:
        recipe=lambda wildcards: RECIPES[wildcards.recording],
        code=library("recording_reference"),
    script:
        "../scripts/recording_reference.py"


rule recordings_page:
    """Tabulate what was found on each recording, what was seen but not named, what was left out, and the distances."""
    input:
        properties=expand("results/recordings/{recording}/properties.json", recording=RECORDINGS),
        reports=expand("results/recordings/{recording}/report.json", recording=RECORDINGS),
        biases=expand("results/recordings/{recording}/biases.csv", recording=REFERENCED),
    output:
        overview=table("recordings", "Discovery", "recordings of other devices (tables)", caption="recordings"),
        effects=table("recordings_effects", "Discovery", "recordings of other devices (tables)", caption="recordings"),
        withheld=table("recordings_withheld", "Discovery", "recordings of other devices (tables)", caption="recordings"),
        biases=table("recordings_biases", "Discovery", "recordings of other devices (tables)", caption="recordings"),
        numbers="paper/numbers/recordings.json",
    log:
        "logs/recordings_page.log",
    params:
        titles={name: RECIPES[name]["title"] for name in RECORDINGS},
        referenced=REFERENCED,
        code=library("recordings_page"),
    script:
        "../scripts/recordings_page.py"


rule facts_page:
    """Tabulate which facts that publishers and makers state of the recordings were found, with the misses."""
    input:
        facts="data/facts.csv",
        parameters=expand("results/recordings/{recording}/parameters.csv", recording=RECORDINGS),
    output:
        table=table("facts", "Discovery", "stated facts (table)", caption="recordings"),
        numbers="paper/numbers/facts.json",
    log:
        "logs/facts_page.log",
    params:
        titles={name: RECIPES[name]["title"] for name in RECORDINGS},
        code=library("facts_page"),
    script:
        "../scripts/facts_page.py"


PAPER["discovery"] += [*rules.recordings_page.output, *rules.facts_page.output] if RECORDINGS else []
