import json

import pytest
from hypothesis import HealthCheck, settings

settings.register_profile("derandomised", derandomize=True, deadline=None, suppress_health_check=[*HealthCheck])
settings.load_profile("derandomised")


@pytest.fixture(scope="session")
def short():
    """The recipe with logs of a minute and with all kinds of cases."""
    from imu_benchmark import recipe

    shares = {"single": 0.4, "pair": 0.15, "triple": 0.15, "nothing": 0.2, "unknown": 0.1}
    return recipe.read() | {
        "shares": shares, "rates_hz": [25], "duration_s": [40, 60], "motion_duration_s": [40, 60],
    }  # fmt: skip


@pytest.fixture(scope="session")
def made(short, tmp_path_factory):
    """A benchmark of twenty cases: the folder that is published, and the file of the keys."""
    from imu_benchmark import commitments

    folder = tmp_path_factory.mktemp("benchmark")
    commitments.make(20261129, 20, short, folder / "public", folder / "secret.json")
    return folder / "public", folder / "secret.json"


@pytest.fixture
def write_entry():
    """Write an entry: a report for each case."""

    def write(folder, reports):
        for case, report in reports.items():
            (folder / case).mkdir(parents=True)
            (folder / case / "report.json").write_text(json.dumps(report))
        return folder

    return write
