"""Readers of start models: one line per tool; a file that none recognises is a model of this library.

A model is taken by the path of its file, or by the name of a device of which one is shipped.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree.ElementTree import Element

from imugap.effects.effect import Effect
from imugap.interchange.devices.card import DeviceCard, is_card
from imugap.interchange.devices.catalogue import located
from imugap.interchange.start_models import (
    airsim,
    document,
    gazebo,
    genesis,
    gnss_ins_sim,
    kalibr,
    kf_gins,
    matlab,
    pegasus,
    vins,
)
from imugap.interchange.start_models.reading import Reader, Reading
from imugap.model import ErrorModel

READERS: tuple[Reader, ...] = (
    gazebo.READER, kalibr.READER, vins.READER, kf_gins.READER, airsim.READER, gnss_ins_sim.READER, pegasus.READER,
    genesis.READER, matlab.READER,
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class ModelFile:
    """File with an error model, opened and recognised.

    Attributes
    ----------
    path
        The file, or the name of a device model, as it was given.
    model
        Its model, where it is a file of this library.
    reader, content
        Reader of the tool that the file is of, and its content, for another one.
    device
        Device model, for a file with a card.
    file
        The file that was read; None for a model that is no file.
    """

    path: Path
    model: ErrorModel | None = None
    reader: Reader | None = None
    content: document.Document | None = None
    device: DeviceCard | None = None
    file: Path | None = None

    @classmethod
    def open(cls, path: str | Path, catalogue: Mapping[str, type[Effect]]) -> "ModelFile":
        """Open and recognise a file, or the model of a device by its name; ValueError for one that is no model."""
        file = located(path)
        content = document.read(file)
        reader = next((one for one in READERS if content is not None and one.recognises(content)), None)
        if reader is not None:
            return cls(Path(path), reader=reader, content=content, file=file)
        if is_card(content):
            try:
                return cls(Path(path), device=DeviceCard.of(content, catalogue), file=file)
            except ValueError as error:
                raise ValueError(f"{path}: {error}") from error
        if isinstance(content, Element | tuple):
            tools = ", ".join(one.tool for one in READERS)
            raise ValueError(f"{path}: expected a model, or a file of {tools}; found none of them")
        return cls(Path(path), ErrorModel.read(file, catalogue), file=file)

    def at(self, rate: float | None) -> Reading:
        """Return the model at a sampling rate [Hz], and what was recognised; ValueError with the path for a fault."""
        if self.device is not None:
            return Reading(self.device.model, self.device.remarks(rate))
        if self.reader is None:
            return Reading(self.model)
        try:
            found = self.reader.read(self.content, rate)
        except ValueError as error:
            raise ValueError(f"{self.path}: {error}") from error
        effects = sum(len(tuple(one)) for one in found.model.axes.values())
        if not effects:
            raise ValueError(f"{self.path}: expected errors of an IMU in the file of {self.reader.tool}; found none")
        return replace(found, remarks=(f"recognised as a file of {self.reader.tool}", *found.remarks))
