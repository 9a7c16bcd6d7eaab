"""The content of a test certificate (ISO/IEC 17025:2017, 7.8): one model for JSON, HTML and PDF.

A number that is printed stands here twice: as the float it comes from, and as the text that was
printed, with its decimals, so that a reader can recompute the one and compare it with the other.
Texts of a document in a natural language are the formats' business: here are codes and facts.
"""

from __future__ import annotations

import json
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, JsonValue, ValidationError

from rigrunner.api.errors import DataError

_IN_SCRIPT = str.maketrans({"<": "\\u003c", ">": "\\u003e", "&": "\\u0026"})
"""JSON escapes that let a text stand inside an HTML element as it is."""

Text = Annotated[str, Field(min_length=1)]
Sha256 = Annotated[str, Field(pattern=r"^([0-9a-f]{64})?$")]
"""A digest in hexadecimal; empty where there is none."""


class Part(BaseModel):
    """Frozen, strict, no unknown keys: the base of all that a certificate consists of."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, use_attribute_docstrings=True
    )


class Laboratory(Part):
    """Who issues the certificate (7.8.2.1 b, c)."""

    name: Text
    address: Annotated[tuple[Text, ...], Field(min_length=1)]
    """Line by line."""
    place: Text
    """Where the test was done: the laboratory's own premises, or another place."""
    contact: str = ""
    accreditation: str = ""
    """What the laboratory says of its accreditation, verbatim; empty for none."""


class Customer(Part):
    """For whom the test was done (7.8.2.1 e)."""

    name: Text
    contact: Text
    reference: str = ""
    """The customer's own number of the order."""


class Item(Part):
    """What was tested (7.8.2.1 g, h, k; 7.8.2.2)."""

    description: Text
    identification: Text
    condition: Text
    """As it was received."""
    received: Text
    """The date of receipt, as 2026-01-31."""
    sampling: str = ""
    """Plan and method of sampling, where the laboratory did it; empty: tested as received."""


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
    called: dict[str, Sha256] = {}
    """The same of each procedure that it calls, by file."""
    approval: Approval
    symbol: Text
    measurand: Text
    """Of the procedure, in words."""
    compensation: Text
    """The primary method, by its name."""
    quantity: Text
    """What that method yields, in words."""
    analysis: dict[str, JsonValue]
    """The settings of the analysis, resolved to defaults."""


class Performance(Part):
    """When, where and by whom it was measured (7.8.2.1 c, i)."""

    started_utc: Text
    ended_utc: Text
    station: Text
    mandrel: str
    operator: Text
    inputs: dict[str, str] = {}
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


class StatedResult(Part):
    """An estimate with its expanded uncertainty, as printed (7.8.2.1 m, 7.8.3.1 c; GUM 7.2)."""

    value: float
    standard_uncertainty: float
    degrees_of_freedom: float | None
    """None where they are infinite."""
    coverage_factor: float
    coverage_probability: float = 0.95
    expanded_uncertainty: float
    unit: Text
    decimals: int
    """Of both printed texts: U has two significant digits (GUM 7.2.6)."""
    printed: Text
    printed_uncertainty: Text
    printed_factor: Text


class PointResult(Part):
    """The result of one set-point."""

    recording: Text
    set_frequency_hz: float
    frequency_hz: float
    load_n: float
    cycles: int
    cycles_rejected: int
    """Not in the torque, as the rule for gross errors found them."""
    raw_nm: float
    """What the sensor shows, uncompensated: the mean of the peaks that were kept."""
    printed_raw: Text
    torque: StatedResult


class Results(Part):
    """What was found (7.8.2.1 m)."""

    headline: StatedResult
    """The mean over the set-points."""
    motion: Literal["swing", "start"]
    """Whether set-points are swings at a frequency or starts from rest at a speed."""
    points: Annotated[tuple[PointResult, ...], Field(min_length=1)]


class LimitStatement(Part):
    """What one limit says of one result."""

    of: Text
    """What is judged: 'mean', or one set-point such as '35 Hz'."""
    verdict: Text
    reason: Text
    """In a sentence, as the run has it."""
    limit: Text
    """As '≤ 0.95 N·m'."""
    lower_nm: float | None
    upper_nm: float | None
    source: Text
    """The specification."""
    measurand: str = ""
    """Of what the limit is a limit, as the specification has it; empty where it does not say."""
    load_n: float | None = None
    """The load that the limit is for, where it names one."""
    guard_band_nm: float | None = None
    printed_guard_band: str = ""
    """With its unit."""
    stated_risk: float | None = None
    """The highest probability that an item which the rule passes does not conform (JCGM 106)."""
    probability_of_conformity: float | None
    printed_probability: str = ""
    """In per cent."""
    uncompensated: Text
    """What the same rule would say of the raw torque."""
    marginal: bool = False
    """Whether a result different by no more than the marginal band had another verdict."""


class DecisionRecord(Part):
    """A decision by which a stored run was decided again, as it is on record beside the run."""

    file: Text
    sha256: Sha256
    """Of that file's bytes."""
    decided_utc: Text
    by: Text
    reason: Text
    """Why it was decided again."""
    verdict: Text
    rule: Text
    """As 'name: the rule in words'."""
    limit: Text
    verdict_before: Text
    """What held until then; 'none' where nothing had been decided."""
    rule_before: Text
    limit_before: Text
    acceptance: dict[str, JsonValue]
    """Limits and rule, as a procedure writes them: by these the verdict can be derived again."""


class Conformity(Part):
    """The statement of conformity with its decision rule (7.8.6)."""

    verdict: Text
    rule: Text
    """The rule's name, as in the procedure."""
    rule_words: str
    """The rule in words, as the run has it."""
    statements: Annotated[tuple[LimitStatement, ...], Field(min_length=1)]
    """Of every limit, the one that decides first."""
    decided_again: tuple[DecisionRecord, ...] = ()
    """Decisions after the run's own, oldest first: what is stated here is by the last of them."""


class Opinion(Part):
    """An opinion or interpretation, marked as such (7.8.7)."""

    text: Text
    by: Text


class ExternalResult(Part):
    """A result that another provider supplied (7.8.2.1 p)."""

    text: Text
    provider: Text


DeviationKind = Literal[
    "intervention",
    "override",
    "alarm",
    "note",
    "failed_step",
    "repeated",
    "failed_check",
    "remark",
    "calibration",
    "stated",
]


class Deviation(Part):
    """One addition to, deviation from or exclusion from the method (7.8.2.1 n)."""

    kind: DeviationKind
    run_id: Text
    """Of the run in which it happened: this one or its no-load run."""
    where: str = ""
    """Step, source, check or channel."""
    text: str
    """As recorded."""
    by: str = ""
    reason: str = ""
    utc: str = ""


class RejectedCycle(Part):
    """A cycle that the rule for gross errors left out; the raw data stay."""

    run_id: Text
    recording: Text
    cycle: int
    """From 1."""
    what: Literal["peak", "waveform"]
    rule: Text
    value_nm: float | None
    statistic: float | None
    critical: float | None
    printed_statistic: Text
    printed_critical: Text


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
    conditions: dict[str, str] = {}
    """In which surroundings the calibration holds, by quantity."""
    overdue: bool = False
    """At the start of the run."""
    calibration: Literal["calibrated", "simulated", "recorded", "trial"] = "calibrated"
    """Why there is nothing to calibrate, where the register says so."""


class Authorisation(Part):
    """Who authorises the certificate (7.8.2.1 o)."""

    by: Text
    role: str = ""


class Change(Part):
    """One field that an amendment changed."""

    field: Text
    """The way to it: 'customer.name'."""
    before: str
    after: str


class Amendment(Part):
    """What this document replaces, and why (7.8.8)."""

    number: Text
    """Of the document that it replaces."""
    issued_utc: Text
    sha256: Sha256
    """Of that document's JSON."""
    reason: Text
    by: Text
    changes: tuple[Change, ...] = ()


class RunEvidence(Part):
    """The identity of a run's recordings."""

    run_id: Text
    procedure_id: Text
    procedure_revision: Text
    started_utc: Text
    digest_sha256: Sha256
    """Over recordings and measurements."""
    manifest_sha256: Sha256 = ""
    """Over the manifest of everything in the run; empty in runs older than manifests."""
    file_sha256: Sha256 = ""
    """Of the bytes of `run.h5`; empty for a run that is embedded in another's file."""


class Evidence(Part):
    """By what the results can be proved to follow from the recordings."""

    run: RunEvidence
    no_load_run: RunEvidence | None
    station_sha256: Sha256
    """Of the station's text in UTF-8."""
    software: dict[str, str]
    """With what the run was made."""
    issued_with: dict[str, str]
    """With what the certificate was made."""


class Restriction(Part):
    """Why the document is no certificate, but a specimen."""

    code: Literal["draft_procedure", "simulated", "trial", "replayed", "requested"]
    detail: str = ""


class Appearance(Part):
    """What the printed forms depend on besides this content."""

    language: Text
    files: dict[str, Sha256] = {}
    """The letterhead's files by name: logo, templates, texts, style."""


class Certificate(Part):
    """A test certificate."""

    rigrunner: Literal["certificate/1"] = "certificate/1"
    number: Text
    """Unique in the laboratory; on every page."""
    issued_utc: Text
    restrictions: tuple[Restriction, ...] = ()
    """If there is any, the document is 'not for certification' and says so on every page."""
    amends: Amendment | None = None
    laboratory: Laboratory
    customer: Customer
    item: Item
    method: Method
    performance: Performance
    conditions: tuple[Condition, ...]
    conditions_stated: str = ""
    """What a person says of the conditions."""
    results: Results
    conformity: Conformity | None
    """None where the procedure has no limits."""
    opinions: tuple[Opinion, ...] = ()
    external: tuple[ExternalResult, ...] = ()
    deviations: tuple[Deviation, ...]
    rejected: tuple[RejectedCycle, ...]
    instruments: tuple[InstrumentEntry, ...]
    statements: tuple[Text, ...] = ()
    """What the laboratory says on each certificate besides."""
    authorisation: Authorisation
    evidence: Evidence
    appearance: Appearance
    seal: str | None = None
    """Of a file: SHA-256 of its bytes before this member, and digests of its blocks."""


def certificate_json(certificate: Certificate) -> str:
    """Return the certificate as JSON: the same content gives the same bytes (UTF-8).

    `<`, `>` and `&` are escaped, so that the same text stands in the file and inside a page.
    """
    content = certificate.model_dump(mode="json", exclude={"seal"})
    text = json.dumps(content, ensure_ascii=False, indent=1, allow_nan=False)
    return text.translate(_IN_SCRIPT) + "\n"


def parse_certificate(text: str | bytes, name: str) -> Certificate:
    """Return the certificate in a JSON text; `name` stands for the file in messages.

    Raises DataError that names the first field that is wrong.
    """
    try:
        return Certificate.model_validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(step) for step in first["loc"])
        count = error.error_count()
        more = f" (and {count - 1} more)" if count > 1 else ""
        raise DataError(
            f"{name} is no certificate: {f'{where}: ' if where else ''}{first['msg']}{more}",
            hint="needed is the JSON file that 'rigrunner certify' wrote",
        ) from error
