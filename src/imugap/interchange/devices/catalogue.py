"""Device models that are shipped with the library, by name."""

from pathlib import Path

from imugap import spelling
from imugap.effects import CATALOGUE
from imugap.interchange.devices.card import DeviceCard
from imugap.io import strict_yaml

FOLDER = Path(__file__).with_name("models")


def names() -> list[str]:
    """Return the names of all device models."""
    return sorted(path.stem for path in FOLDER.glob("*.yaml"))


def read(name: str) -> DeviceCard:
    """Return the device model of a name; ValueError with the nearest name where there is none."""
    if name not in names():
        raise ValueError(f"model: expected {spelling.expected(name, names())}; found {name!r}")
    return DeviceCard.of(strict_yaml.read(FOLDER / f"{name}.yaml"), CATALOGUE)


def model_file(path: str | Path, folder: Path = Path()) -> Path:
    """Return the file of a device model for its name, unless a folder has a file of that name; else the path there."""
    own = folder / path
    return FOLDER / f"{path}.yaml" if str(path) in names() and not own.is_file() else own


def located(path: str | Path) -> Path:
    """Return the file that a path or the name of a device model stands for; a file of that name goes first.

    A bare name that is neither is a ValueError with the nearest device; any other path is returned as it is.
    """
    path = Path(path)
    file = model_file(path)
    if file.exists() or path.name != str(path) or path.suffix:
        return file
    hint = spelling.hint(path.name, names()) or " (`imugap models` lists them)"
    raise ValueError(f"{path}: model: expected a file or the name of a device{hint}; found neither")
