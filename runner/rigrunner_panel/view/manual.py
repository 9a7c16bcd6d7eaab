"""What the manual page shows."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class DriveView(BaseModel):
    """A drive that can be set by hand, with its limits in SI units."""

    model_config = ConfigDict(frozen=True)

    name: str
    long_name: str
    unit: str
    minimum: float
    maximum: float
    set: float | None


class ManualView(BaseModel):
    """The drives, what is and was recorded, and why the last request was refused."""

    model_config = ConfigDict(frozen=True)

    drives: tuple[DriveView, ...]
    channels: tuple[str, ...]
    recording: str
    refused: str = ""
    points: int = 0
    """How many points are recorded."""
    last: str = ""
    """The recording of the last one."""
