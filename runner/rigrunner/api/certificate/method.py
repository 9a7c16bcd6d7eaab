"""How, when, where and with which instruments it was measured."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, JsonValue

from rigrunner.api.certificate.part import Part, Sha256, Text


class Approval(Part):
    """The state of the procedure when the run was made."""

    state: Text
    """'approved', 'draft', or what else the run says of it."""
    by: str = ""
    utc: str = ""
    sha256: Sha256 = ""
    note: str = ""
    """Why it is a draft although somebody once approved it."""


class Method(Part):
    """How it was measured and computed (7.8.2.1 f)."""

    procedure_id: Text
    revision: Text
    title: Text
    sha256: Sha256
    """Of the procedure's text in UTF-8."""
    called: dict[str, Sha256] = Field({})
    """The same of each procedure that it calls, by file."""
    approval: Approval
    symbol: str
    measurand: str
    """Of the procedure, in words; both empty where analyses name their results."""
    compensation: str
    """The primary method, by its name; empty where nothing was analysed."""
    quantity: str
    """What that method yields, in words; empty with it."""
    analysis: dict[str, JsonValue]
    """The settings of the analysis, resolved to defaults."""


class Performance(Part):
    """When, where and by whom it was measured (7.8.2.1 c, i)."""

    started_utc: Text
    ended_utc: Text
    station: Text
    mandrel: str
    operator: Text
    inputs: dict[str, str] = Field({})
    """What was entered at the start, and answered in the course of the run."""


class Condition(Part):
    """What the station read of its surroundings while recording (7.8.3.1 a)."""

    channel: Text
    """'role.name'."""
    quantity: Text
    """The channel's own name: 'temperature', 'humidity', 'load'."""
    minimum: float
    maximum: float
    printed_minimum: Text
    printed_maximum: Text
    decimals: int
    unit: Text


class ValidityCondition(Part):
    """A condition on which the results hold, by the kind of the measurand."""

    code: Text
    """Such as 'support_friction': as the analysis names it."""
    allowance: str = ""
    """How much is allowed for, as printed."""


class Traceability(Part):
    """Whether the results are metrologically traceable (7.8.3.1, 6.5)."""

    claimed: bool
    """Whether every instrument that the results rest on is calibrated and was not overdue."""
    certificates: tuple[Text, ...] = ()
    """The numbers of their calibration certificates."""


class InstrumentEntry(Part):
    """An instrument of the register (7.8.3.1; traceability, 6.5)."""

    channel: Text
    id: str = ""
    """The laboratory's own number of it."""
    maker: str
    type: str
    serial: str
    certificate: str
    laboratory: str
    calibrated: str
    """A date as 2026-01-31; empty where the register has none."""
    due: str
    range: str
    uncertainty: dict[str, str]
    """Limits of error, or the uncertainty, by the name of the part they belong to."""
    conditions: dict[str, str] = Field({})
    """In which surroundings the calibration holds, by quantity."""
    overdue: bool = False
    """At the start of the run."""
    calibration: Literal["calibrated", "simulated", "recorded", "trial"] = "calibrated"
    """Why there is nothing to calibrate, where the register says so."""
