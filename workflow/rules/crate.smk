rule crate:
    """Describe the last run as a Provenance Run Crate: which job made which file from which, and when."""
    input:
        software="codemeta.json",
    output:
        "ro-crate-metadata.json",
    log:
        "logs/crate.log",
    params:
        code=library("crate"),
    script:
        "../scripts/crate.py"
