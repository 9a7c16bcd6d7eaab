"""The method, time, place, conditions and instruments of the measurement."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, JsonValue

from rigrunner.api.certificate.part import Part, Sha256, Text


class Approval(Part):
    """The state of the procedure at the start of the run."""

    state: Text
    """'approved', 'draft', or another state in the run."""
    by: str = ""
    utc: str = ""
    sha256: Sha256 = ""
    note: str = ""
    """Why it is a draft in spite of an earlier approval."""


class Method(Part):
    """The method of measurement and analysis (7.8.2.1 f)."""

    procedure_id: Text
    revision: Text
    title: Text
    sha256: Sha256
    """Digest of the procedure's text in UTF-8."""
    called: dict[str, Sha256] = Field({})
    """The digest of each procedure that it calls, by file."""
    approval: Approval
    symbol: str
    measurand: str
    """The measurand of the procedure; both empty if analyses name their results."""
    compensation: str
    """Name of the primary method; empty without an analysis."""
    quantity: str
    """The quantity that it yields, in words; empty without one."""
    analysis: dict[str, JsonValue]
    """The settings of the analysis, with defaults."""


class Performance(Part):
    """Time, place and operator of the measurement (7.8.2.1 c, i)."""

    started_utc: Text
    ended_utc: Text
    station: Text
    mandrel: str
    operator: Text
    inputs: dict[str, str] = Field({})
    """Inputs at the start of the run, and answers during it."""


class Condition(Part):
    """An ambient condition, read during recordings (7.8.3.1 a)."""

    channel: Text
    """'role.name'."""
    quantity: Text
    """The name of the channel: 'temperature', 'humidity', 'load'."""
    minimum: float
    maximum: float
    printed_minimum: Text
    printed_maximum: Text
    decimals: int
    unit: Text


class ValidityCondition(Part):
    """A condition on which the results hold, by the kind of the measurand."""

    code: Text
    """Name in the analysis, such as 'support_friction'."""
    allowance: str = ""
    """The amount that is allowed for, as printed."""


class Traceability(Part):
    """Whether the results are metrologically traceable (7.8.3.1, 6.5)."""

    claimed: bool
    """Whether all instruments behind the results are calibrated and were not overdue."""
    certificates: tuple[Text, ...] = ()
    """The numbers of their calibration certificates."""


class InstrumentEntry(Part):
    """An instrument of the register (7.8.3.1; traceability, 6.5)."""

    channel: Text
    id: str = ""
    """Inventory number of the laboratory."""
    maker: str
    type: str
    serial: str
    certificate: str
    laboratory: str
    calibrated: str
    """A date such as 2026-01-31; empty if the register has none."""
    due: str
    range: str
    uncertainty: dict[str, str]
    """Limits of error, or the uncertainty, by the name of the error."""
    conditions: dict[str, str] = Field({})
    """Ambient conditions for which the calibration is valid, by quantity."""
    overdue: bool = False
    """At the start of the run."""
    calibration: Literal["calibrated", "simulated", "recorded", "trial"] = "calibrated"
    """Why it needs no calibration, if the register states that."""
