"""`tape.json`: what was recorded, to explain why a replay differs."""

from __future__ import annotations

from datetime import datetime
from typing import TYPE_CHECKING, Literal

from pydantic import BaseModel, ConfigDict, ValidationError

from rigrunner.api.errors import DataError, first_problem

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

NAME = "tape.json"


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class TapedFile(_Part):
    """A procedure or a station: its id, and the digest of its text."""

    id: str
    sha256: str


class TapedPlugin(_Part):
    """The plugin of an instrument."""

    plugin: str
    provider: str
    settings_sha256: str


class TapedOverride(_Part):
    """An override of a calibration check."""

    what: str
    subject: str
    by: str
    reason: str


class TapeManifest(_Part):
    """What was recorded."""

    rigrunner: Literal["tape/1"] = "tape/1"
    program: str
    """The version of Rigrunner that recorded it."""
    began_utc: datetime
    station: TapedFile
    devices: dict[str, TapedPlugin]
    """By role."""
    procedure: TapedFile | None = None
    """None for manual mode."""
    attended: bool = False
    """Whether a person could pause the run."""
    watches_drives: bool = False
    """Whether drives were read back during readings; not in tapes of 0.1.0."""
    inputs: dict[str, str] = {}
    """The answers to the procedure's inputs."""
    overrides: tuple[TapedOverride, ...] = ()


def read_manifest(folder: Path) -> TapeManifest:
    """Return the manifest of a tape; raise DataError if there is none."""
    path = folder / NAME
    try:
        return TapeManifest.model_validate_json(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise DataError(
            f"{folder} holds no tape: {path.name}: {error.strerror or error}",
            hint="a tape is a folder that --record wrote",
        ) from error
    except (ValidationError, ValueError) as error:
        what = f": {first_problem(error)}" if isinstance(error, ValidationError) else ""
        raise DataError(f"{path} is not a tape that this Rigrunner knows{what}") from error


def differences(then: TapeManifest, now: TapeManifest) -> Iterator[str]:
    """Yield, as text, what differs from the recording."""
    if then.program != now.program:
        yield f"the tape is of Rigrunner {then.program}, this is {now.program}"
    for what in ("procedure", "station"):
        if getattr(then, what) != getattr(now, what):
            yield f"the {what} is not the one of the tape"
    for role in {**then.devices, **now.devices}:
        recorded, present = then.devices.get(role), now.devices.get(role)
        if present is None or recorded is None:
            lacks = "station" if present is None else "tape"
            yield f"the {lacks} has no device in the role '{role}'"
        elif present.plugin != recorded.plugin:
            yield f"{role} is driven by '{present.plugin}', on the tape by '{recorded.plugin}'"
        elif present.provider != recorded.provider:
            yield f"the plugin of {role} is of {present.provider}, on the tape {recorded.provider}"
        elif present != recorded:
            yield f"the settings of {role} are not those of the tape"
