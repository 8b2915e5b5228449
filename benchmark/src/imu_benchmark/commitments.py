"""Commitments: a benchmark is published with digests of its cases and of its keys, and the keys afterwards.

The digest of a key is that of a random nonce and the key, so that nobody can find the key by trying. A folder that is
published holds ``cases`` and ``manifest.json``; the file of the keys stays secret until they are revealed beside them
as ``keys.json``. What does not have the digest of the manifest is refused.
"""

import json
import secrets
import shutil
from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path

from imu_benchmark import recipe as recipes
from imu_benchmark.schema import FormatError, check, load, read_json
from imu_benchmark.sealing import plan, seal, write

CASES, MANIFEST, KEYS = "cases", "manifest.json", "keys.json"
SHOWN = 12
"""Digits of a digest that a message shows."""


def make(seed: int, cases: int, recipe: Mapping, public: str | Path, secret: str | Path) -> None:
    """Make cases: logs and manifest in the new folder ``public``, plan and keys in the new file ``secret``."""
    public, secret = Path(public), Path(secret)
    for path in (public, secret):
        if path.exists():
            raise FormatError(path, "", "nothing, for it is made", "a file or a folder")
    if public.resolve() in secret.resolve().parents:
        raise FormatError(secret, "", f"a place outside of {public}", "one that is published with it")
    drawn, keys = public / CASES, public / "sealing"
    for case in plan(seed, cases, recipe):
        write(seal(case, recipe), drawn, keys)
    truth = {path.stem: _sealed(read_json(path)) for path in sorted(keys.glob("*.json"))}
    shutil.rmtree(keys)
    of_plan = _sealed({"seed": seed, "cases": cases, "recipe": recipe})
    manifest = {
        "schema": "imu-benchmark/manifest/1",
        "plan": commitment(of_plan),
        "cases": {case: {"files": _digests(drawn / case), "key": commitment(sealed)} for case, sealed in truth.items()},
    }
    secret.parent.mkdir(parents=True, exist_ok=True)
    _write_json({"schema": "imu-benchmark/keys/1", "plan": of_plan, "keys": truth}, secret)
    _write_json(manifest, public / MANIFEST)


def commitment(sealed: Mapping) -> str:
    """Return the SHA-256 of the nonce and of the record, as JSON with sorted keys and without spaces."""
    record = json.dumps(sealed["record"], sort_keys=True, separators=(",", ":"))
    return sha256(f"{sealed['nonce']}{record}".encode()).hexdigest()


def read_cases(public: str | Path) -> list[str]:
    """Return the names of the cases of a folder, if all of its files have the digests of its manifest."""
    folder = Path(public) / CASES
    stated = {case: item["files"] for case, item in _manifest(public)["cases"].items()}
    present = {path.name for path in folder.iterdir()} if folder.is_dir() else set()
    strange = sorted(present ^ set(stated))
    if strange:
        expected = "a case" if strange[0] in stated else "no case that the manifest does not have"
        raise FormatError(folder / strange[0], "", expected, "none" if strange[0] in stated else "one")
    for case, files in stated.items():
        _require_same(files, _digests(folder / case), folder / case)
    return list(stated)


def reveal(secret: str | Path, public: str | Path) -> None:
    """Write the secret keys beside the cases, if they have the digests of the manifest."""
    keys = _checked_keys(secret, public)
    _write_json(keys, Path(public) / KEYS)


def read_keys(public: str | Path) -> list[dict]:
    """Return the revealed keys in the order of the cases, if they have the digests of the manifest."""
    return read_secret(Path(public) / KEYS, public)


def read_secret(secret: str | Path, public: str | Path) -> list[dict]:
    """Return the keys of a file in the order of the cases, if they have the digests of the manifest."""
    keys = _checked_keys(secret, public)["keys"]
    return [keys[case]["record"] for case in _manifest(public)["cases"]]


def _checked_keys(path: str | Path, public: str | Path) -> dict:
    keys, manifest = read_json(path), _manifest(public)
    check(keys, load("keys"), path)
    stated = {case: item["key"] for case, item in manifest["cases"].items()} | {"plan": manifest["plan"]}
    found = {case: commitment(sealed) for case, sealed in keys["keys"].items()} | {"plan": commitment(keys["plan"])}
    _require_same(stated, found, path)
    for case, sealed in keys["keys"].items():
        check(sealed["record"], load("key"), f"{path}: {case}")
        if sealed["record"]["case"] != case:
            raise FormatError(path, case, "the key of this case", f"that of {sealed['record']['case']}")
    recipes.checked(keys["plan"]["record"]["recipe"], f"{path}: plan")
    return keys


def _require_same(stated: Mapping[str, str], found: Mapping[str, str], source: Path | str) -> None:
    """Refuse the first digest that is not as stated."""
    for name in sorted({*stated, *found}):
        expected, actual = (digests.get(name, "none")[:SHOWN] for digests in (stated, found))
        if stated.get(name) != found.get(name):
            raise FormatError(source, name, f"the digest {expected} of the manifest", actual)


def _manifest(public: str | Path) -> dict:
    path = Path(public) / MANIFEST
    manifest = read_json(path)
    check(manifest, load("manifest"), path)
    return manifest


def _sealed(record: Mapping) -> dict:
    return {"nonce": secrets.token_hex(16), "record": record}


def _digests(folder: Path) -> dict[str, str]:
    return {path.name: sha256(path.read_bytes()).hexdigest() for path in sorted(folder.iterdir())}


def _write_json(record: Mapping | Sequence, path: Path) -> None:
    path.write_text(json.dumps(record, indent=1) + "\n")
