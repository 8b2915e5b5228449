"""The stated facts speak of recordings, axes, effects and parameters that exist."""

from pathlib import Path

import pandas as pd
import yaml

from imugap.effects import CATALOGUE
from imugap.log import AXES

DATA = Path(__file__).parents[2] / "data"


def test_every_fact_can_be_looked_up_in_what_discovery_writes():
    facts = pd.read_csv(DATA / "facts.csv")
    recordings = yaml.safe_load((DATA / "recordings.yaml").read_text())
    assert len(facts) >= 8
    for fact in facts.itertuples(index=False):
        assert fact.recording in recordings
        assert set(fact.axes.split()) <= set(AXES)
        assert fact.parameter in CATALOGUE[fact.effect].units("")
        assert 0 < fact.low < fact.high
        assert fact.source
