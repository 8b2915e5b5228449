import json
import shutil

import pytest

from imu_benchmark import commitments
from imu_benchmark.case import read_case
from imu_benchmark.schema import FormatError


@pytest.fixture
def copy(made, tmp_path):
    """A copy of the benchmark that a test may spoil."""
    public, secret = made
    shutil.copytree(public, tmp_path / "public")
    shutil.copy(secret, tmp_path / "secret.json")
    return tmp_path / "public", tmp_path / "secret.json"


def changed(path, change):
    record = json.loads(path.read_text())
    change(record)
    path.write_text(json.dumps(record))


def test_what_is_made_is_what_the_manifest_says(made):
    public, secret = made
    assert commitments.read_cases(public) == [f"c{number:04}" for number in range(1, 21)]
    assert {path.name for path in public.iterdir()} == {"cases", "manifest.json"}
    keys = json.loads(secret.read_text())["keys"].values()
    assert {one["record"]["kind"] for one in keys} == {"single", "pair", "triple", "nothing", "unknown"}
    assert max(len(one["record"]["effects"]) for one in keys) == 3


def test_revealed_keys_are_the_secret_ones_in_the_order_of_the_cases(copy):
    public, secret = copy
    commitments.reveal(secret, public)
    keys = commitments.read_keys(public)
    assert [key["case"] for key in keys] == commitments.read_cases(public)
    sealed = json.loads(secret.read_text())["keys"]
    assert keys == [sealed[key["case"]]["record"] for key in keys]


def test_a_commitment_does_not_show_its_record_and_depends_on_every_part():
    one = {"nonce": "ab", "record": {"a": 1, "b": [2]}}
    assert commitments.commitment(one) == commitments.commitment({"record": {"b": [2], "a": 1}, "nonce": "ab"})
    others = [one | {"nonce": "ac"}, one | {"record": {"a": 1, "b": [3]}}, one | {"record": {"a": 1}}]
    assert len({commitments.commitment(each) for each in (one, *others)}) == 4


def flip(path):
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(bytes(data))


SPOILT_CASES = {
    "a bit": lambda public: flip(next((public / "cases/c0001").iterdir())),
    "a file more": lambda public: (public / "cases/c0001/more.csv").write_text("x"),
    "a file less": lambda public: next((public / "cases/c0001").iterdir()).unlink(),
    "a case more": lambda public: (public / "cases/c9999").mkdir(),
    "a case less": lambda public: shutil.rmtree(public / "cases/c0001"),
    "no cases": lambda public: shutil.rmtree(public / "cases"),
    "no manifest": lambda public: (public / "manifest.json").unlink(),
    "no JSON": lambda public: (public / "manifest.json").write_text("{"),
    "another manifest": lambda public: (public / "manifest.json").write_text("[]"),
}


@pytest.mark.parametrize("spoil", SPOILT_CASES.values(), ids=SPOILT_CASES)
def test_cases_that_are_not_those_of_the_manifest_are_refused_in_one_line(copy, spoil):
    public, _ = copy
    spoil(public)
    with pytest.raises(FormatError, match=r"expected .*; found ") as refused:
        commitments.read_cases(public)
    assert "\n" not in str(refused.value)


def size_of_first(keys):
    sealed = next(one for one in keys["keys"].values() if one["record"]["effects"])
    sealed["record"]["effects"][0]["size"] *= 2


def exchanged(keys):
    one, other = list(keys["keys"])[:2]
    keys["keys"][one], keys["keys"][other] = keys["keys"][other], keys["keys"][one]


SPOILT_KEYS = {
    "another size": size_of_first,
    "another nonce": lambda keys: keys["keys"]["c0001"].update(nonce="0" * 32),
    "another seed": lambda keys: keys["plan"]["record"].update(seed=1),
    "a key less": lambda keys: keys["keys"].pop("c0001"),
    "a key more": lambda keys: keys["keys"].update(c9999=keys["keys"]["c0001"]),
    "exchanged keys": exchanged,
    "no plan": lambda keys: keys.pop("plan"),
    "another version": lambda keys: keys.update(schema="imu-benchmark/keys/0"),
}


@pytest.mark.parametrize("change", SPOILT_KEYS.values(), ids=SPOILT_KEYS)
def test_keys_that_are_not_those_of_the_manifest_are_refused_in_one_line(copy, change):
    public, secret = copy
    commitments.reveal(secret, public)
    changed(public / "keys.json", change)
    with pytest.raises(FormatError, match=r"keys\.json: .*expected .*; found ") as refused:
        commitments.read_keys(public)
    assert "\n" not in str(refused.value)
    changed(secret, change)
    with pytest.raises(FormatError):
        commitments.reveal(secret, public)


def test_nothing_is_overwritten_and_keys_are_not_published_with_the_cases(made, short, tmp_path):
    public, secret = made
    with pytest.raises(FormatError, match="expected nothing"):
        commitments.make(1, 1, short, public, tmp_path / "keys.json")
    with pytest.raises(FormatError, match="expected nothing"):
        commitments.make(1, 1, short, tmp_path / "new", secret)
    with pytest.raises(FormatError, match="published with it"):
        commitments.make(1, 1, short, tmp_path / "new", tmp_path / "new/keys.json")


def test_the_same_seed_makes_the_same_cases_with_other_commitments_to_the_keys(made, short, tmp_path):
    public, _ = made
    commitments.make(20261129, 20, short, tmp_path / "public", tmp_path / "keys.json")
    one, other = (json.loads((folder / "manifest.json").read_text()) for folder in (public, tmp_path / "public"))
    for case, item in one["cases"].items():
        assert other["cases"][case]["files"] == item["files"]
        assert other["cases"][case]["key"] != item["key"]


def test_a_case_is_read_as_it_was_made(made):
    public, secret = made
    keys = json.loads(secret.read_text())["keys"]
    for name in commitments.read_cases(public):
        case, key = read_case(public / "cases" / name), keys[name]["record"]
        assert (case.reference is not None) == key["motion"]
        assert case.interval == pytest.approx(1 / key["rate_hz"], rel=1e-3)
        assert bool(case.model) == (key["base"] != "white")
        for axis in case.axes:
            assert abs(case.errors(axis).mean()) < 1e-9
            assert {"white_noise", "quantization"} & set(case.known(axis))
