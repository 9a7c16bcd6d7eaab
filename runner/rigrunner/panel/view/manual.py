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


class ManualPoint(BaseModel):
    """A point that was recorded by hand."""

    model_config = ConfigDict(frozen=True)

    recording: str
    utc: str


class ManualView(BaseModel):
    """The drives, what is being done, and the last refusal."""

    model_config = ConfigDict(frozen=True)

    drives: tuple[DriveView, ...]
    channels: tuple[str, ...]
    recording: str
    points: tuple[ManualPoint, ...]
    refused: str = ""
