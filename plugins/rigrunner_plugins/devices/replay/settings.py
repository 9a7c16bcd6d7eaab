"""Settings of `replay`: the format of the files and the channels in them."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from rigrunner.api import Force, Frequency, Settings, UnitSymbol
from rigrunner_plugins.devices.declared import QuantityName
from rigrunner_plugins.devices.fields import quantity
from rigrunner_plugins.importers.settings import TableSettings

ColumnNumber = Annotated[int, Field(ge=1)]


class ColumnSettings(Settings):
    """Where the samples of a channel are."""

    column: Annotated[
        ColumnNumber | str | None,
        Field(
            description="CSV: the column's name or its number from 1; HDF5: the dataset's path; if "
            "omitted, the manifest gives a constant"
        ),
    ] = None
    unit: Annotated[UnitSymbol, Field(description="unit of the numbers in the file")]
    title: Annotated[str, Field(description="name for plots and reports")] = ""


class ReplaySettings(Settings):
    """Recordings in a folder; a manifest lists them by frequency and load."""

    folder: Annotated[str, Field(description="folder of the recordings and the manifest")]
    manifest: Annotated[str, Field(description="name of the manifest in the folder")] = (
        "manifest.yaml"
    )
    rate: Annotated[Frequency, Field(gt=0, description="samples per second and channel")]
    channels: Annotated[dict[QuantityName, ColumnSettings], Field(min_length=1)]
    """Where the samples of each channel are, by name."""
    table: TableSettings = Field(default_factory=TableSettings)
    max_frequency: Frequency = quantity("35 Hz", "highest frequency that can be set", gt=0)
    max_load: Force = quantity("3 kN", "highest load that can be set", gt=0)
