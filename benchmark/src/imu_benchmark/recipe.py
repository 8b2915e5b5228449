"""Recipe of a benchmark: what its cases are drawn from, in TOML; every key is described in its schema."""

import tomllib
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

from imu_benchmark.schema import FormatError, check, load
from imu_benchmark.sealing.vocabulary import NAMED


def shipped() -> str:
    """Return the text of the recipe of this package."""
    return files("imu_benchmark").joinpath("recipe.toml").read_text()


def read(path: str | Path | None = None) -> dict:
    """Read a recipe, by default that of this package."""
    source = "recipe.toml" if path is None else path
    try:
        recipe = tomllib.loads(shipped() if path is None else Path(path).read_text())
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FormatError(source, "", "TOML", error) from None
    except OSError as error:
        raise FormatError(source, "", "a file", error.strerror) from None
    return checked(recipe, source)


def checked(recipe: dict, source: object = "recipe") -> dict:
    """Return the recipe if it keeps the schema, its ranges rise and its shares and weights are not all zero."""
    check(recipe, load("recipe"), source)
    for place, low, high in _ranges(recipe, ""):
        if low > high:
            raise FormatError(source, place, "a range [low, high]", f"[{low}, {high}]")
    if not sum(recipe["shares"].values()):
        raise FormatError(source, ".shares", "a share above zero", "none")
    for number, pair in enumerate(recipe["confusable"]):
        strange = [name for name in pair if name not in NAMED]
        if strange:
            raise FormatError(source, f".confusable[{number}]", f"names of {', '.join(NAMED)}", strange[0])
    return recipe


def _ranges(part: object, place: str) -> Iterator[tuple[str, float, float]]:
    """Yield place and ends of all ranges: pairs of numbers that are no list of choices."""
    if isinstance(part, dict):
        for name, value in part.items():
            if name not in ("sizes", "pair_sizes", "rates_hz", "confusable"):
                yield from _ranges(value, f"{place}.{name}")
    elif isinstance(part, list):
        yield place, *part
