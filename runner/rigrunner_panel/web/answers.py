"""The bodies of responses."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, RootModel

from rigrunner.api.figures import Figure
from rigrunner_panel.history import RunDetail, RunItem
from rigrunner_panel.view.sections import FileLink, StepView


class Done(BaseModel):
    """It is done, or begun."""

    ok: bool = True


class ToldEvent(BaseModel):
    """An event of a run: its number at this panel, in words, and as the run's record has it."""

    number: int
    text: str
    event: dict[str, object]


class Events(BaseModel):
    """Events of one job, oldest first; `latest` is the number of the latest one of all."""

    version: int
    latest: int
    items: list[ToldEvent]


class Started(BaseModel):
    """The run is started; where the rig was in use, its entry in the queue."""

    ok: bool = True
    entry: int | None = None
    note: str = ""
    """That a run of the procedure has already tested the specimen."""


class Added(BaseModel):
    """The numbers of the new entries."""

    entries: list[int]


class Cleared(BaseModel):
    """How many entries were removed."""

    removed: int


class Stopped(BaseModel):
    """Whether there was something to stop."""

    ok: bool = True
    stopped: bool


class ProcedureItem(BaseModel):
    """A procedure to choose."""

    name: str
    id: str
    title: str
    note: str
    shipped: bool
    last_used_utc: str
    problem: str


class StationItem(BaseModel):
    """A station to choose."""

    name: str
    id: str
    title: str
    shipped: bool
    last_used_utc: str
    problem: str


class Procedures(BaseModel):
    """Last used first."""

    items: list[ProcedureItem]


class Stations(BaseModel):
    """Last used first."""

    items: list[StationItem]


class PlannedProcedure(BaseModel):
    """The procedure of a plan."""

    name: str
    id: str
    title: str
    revision: str
    approval: str
    draft: bool


class PlannedStation(BaseModel):
    """The station of a plan."""

    name: str
    id: str
    title: str
    simulated: bool


class ExpectedReading(BaseModel):
    """The greatest reading to be expected in a recording, and what the instrument can take."""

    recording: str
    cycle_frequency_hz: float | None
    channel: str
    peak: float
    full_scale: float
    unit: str
    share: float


class InputItem(BaseModel):
    """An input of a procedure."""

    name: str
    ask: str
    choices: tuple[str, ...]
    unit: str
    expected: str
    unattended: str | None


class Partner(BaseModel):
    """A partner run that would be used."""

    name: str
    words: str
    """The partner run in words, such as 'dark run'."""
    run: str = ""
    problem: str = ""
    hint: str = ""


class PlanAnswer(BaseModel):
    """What a run would do; nothing was connected."""

    procedure: PlannedProcedure
    station: PlannedStation
    estimated_s: float
    disk_bytes: int
    disk_free_bytes: int
    steps: tuple[StepView, ...]
    readings: tuple[ExpectedReading, ...]
    inputs: tuple[InputItem, ...]
    partners: tuple[Partner, ...]
    warnings: tuple[str, ...]


class OpenedProcedure(BaseModel):
    """A procedure as text."""

    name: str
    text: str
    digest: str
    """SHA-256 of the file: what a save has to name."""
    shipped: bool
    """It comes with the program and cannot be changed; a copy can."""
    changed_utc: str
    changed_by: str
    """Who saved it at this panel; '' for another program."""
    state: Literal["draft", "approved"]
    approval: str
    sha256: str
    """Over the text and all that it calls: what an approval has to name; '' of an invalid one."""


class PlacedProblem(BaseModel):
    """What is wrong in a text, and where: line and column count from 1."""

    message: str
    hint: str = ""
    field: str = ""
    file: str = ""
    """Another file that it is in: one that is called, or the station; '' for the text itself."""
    line: int | None = None
    column: int | None = None


class CheckedProcedure(BaseModel):
    """What a check found."""

    ok: bool
    problems: list[PlacedProblem]
    approval: str
    state: Literal["draft", "approved"]


class ProcedureComparison(BaseModel):
    """What a text changes, in sentences."""

    against: Literal["file", "approved", "run"]
    run: str
    """Whose procedure it is compared with; '' where there is none."""
    same: bool
    verdict: str
    changes: list[ChangeView]


class SavedProcedure(BaseModel):
    """The file was replaced."""

    ok: bool = True
    digest: str


class LanguageSchema(RootModel[dict[str, Any]]):
    """A JSON Schema."""


class InputAnswer(BaseModel):
    """Whether an answer would be accepted; `value` is how it would be recorded."""

    ok: bool
    value: str = ""
    note: str = ""
    """What to know of an accepted answer, such as an earlier test of the specimen."""
    message: str = ""
    hint: str = ""


class Runs(BaseModel):
    """Newest first; `more` where others follow."""

    items: list[RunItem]
    more: bool


class OneRun(RunDetail):
    """A run with the addresses of its files."""

    files: tuple[FileLink, ...]


class Again(BaseModel):
    """What to start with for the next specimen; without a name where it is not in the lists."""

    procedure: str
    station: str
    inputs: dict[str, str]
    operator: str


class IssuedAnswer(BaseModel):
    """A certificate was issued."""

    number: str
    files: tuple[FileLink, ...]
    notes: tuple[str, ...]


class CertificateItem(BaseModel):
    """A certificate in a run's folder."""

    number: str
    issued_utc: str
    by: str
    for_certification: bool
    amends: str
    """The number of the document that it replaces, or ''."""
    reason: str
    replaced_by: str
    withdrawn: str
    """By whom, when and why it was withdrawn, or ''."""
    signed: bool
    files: tuple[FileLink, ...]


class Certificates(BaseModel):
    """Oldest first."""

    items: list[CertificateItem]
    can_sign: bool
    """Whether the panel was started with a key."""


class SignedAnswer(BaseModel):
    """The signature's file."""

    ok: bool = True
    files: tuple[FileLink, ...]


class WithdrawnAnswer(BaseModel):
    """The notice for everyone who has the certificate."""

    ok: bool = True
    files: tuple[FileLink, ...]


class VerificationAnswer(BaseModel):
    """What `rigrunner verify` finds."""

    matches: bool
    conclusion: str
    held: list[str]
    differences: list[str]
    withdrawn: list[str]
    replaced: list[str]
    unproven: list[str]
    not_recomputed: list[str]
    unchecked: list[str]
    information: list[str]


class OverlayRow(BaseModel):
    """A result that is over no set-point, in several runs."""

    name: str
    """With its place, such as 'ripple at state = slow'."""
    unit: str
    values: dict[str, tuple[float, float | None]]
    """Value and U of each run that has it."""


class OverlayAnswer(BaseModel):
    """Figures in which each run is a series."""

    recordings: dict[str, list[str]]
    """The channels of each recording that any of the runs has."""
    results: tuple[Figure, ...]
    rows: list[OverlayRow]
    curve: Figure | None
    """The requested channel over time."""


class ArchiveUpdated(BaseModel):
    """What was found in the folder of runs."""

    runs: int
    new: int
    changed: int
    unreadable: int


class Quantities(BaseModel):
    """Names of what the archive has values of."""

    items: list[str]


class RunAndReason(BaseModel):
    """A run that does not count, and why."""

    run: str
    reason: str


class AlarmAt(BaseModel):
    """A run at which rules are met, after the baseline."""

    run: str
    utc: str
    value: float
    rules: tuple[str, ...]


class ChartOfGroup(BaseModel):
    """The control chart of a group of runs, oldest first."""

    name: str
    centre: float
    lower: float
    upper: float
    runs: list[str]
    alarms: list[AlarmAt]
    warnings: list[str]
    figure: Figure


class TrendAnswer(BaseModel):
    """Control charts of a quantity."""

    quantity: str
    unit: str
    rules: dict[str, str]
    charts: list[ChartOfGroup]
    not_charted: dict[str, str]
    excluded: list[RunAndReason]
    warnings: list[str]


class ChangeView(BaseModel):
    """One difference, in a sentence."""

    section: str
    text: str
    matters: bool


class ComparisonAnswer(BaseModel):
    """What is different between two runs."""

    before: str
    after: str
    same: bool
    verdict: str
    changes: list[ChangeView]
