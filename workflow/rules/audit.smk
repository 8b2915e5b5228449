PUBLISHED = {
    "indices": "data/published/he2023_table1_performance_indices.csv",
    "static": "data/published/he2023_table2_static_navigation.csv",
    "walk": "data/published/he2023_table3_pedestrian_compensation.csv",
}


rule audit:
    """Check the published tables against one another and against physics."""
    input:
        **PUBLISHED,
    output:
        table=table("audit", "Published claims", "audit (table)"),
    log:
        "logs/audit.log",
    params:
        code=library("audit"),
    script:
        "../scripts/audit.py"


rule claims:
    """Confront the published claims with the results here."""
    input:
        **PUBLISHED,
        five=expand("paper/tables/five_trials_{device}.csv", device=DEVICES),
        ranking=expand("paper/tables/ranking_{device}.csv", device=DEVICES),
        scores=expand("results/{device}/drift_scores.csv", device=DEVICES),
        compensation=(["paper/tables/compensation.csv"] if "pedestrian" in CHAPTERS else []),
    output:
        table=table("claims", "Published claims", "claims (table)"),
    log:
        "logs/claims.log",
    params:
        devices=DEVICES,
        table_horizon_s=config["navigation"]["table_horizon_s"],
        code=library("claims"),
    script:
        "../scripts/claims.py"


PAPER["study"] += [*rules.audit.output, *rules.claims.output]
