"""The sections of the state, as sent to screens; see docs/reference/panel-api.md."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field, SkipValidation

from rigrunner.api.coordinates import usual_unit
from rigrunner.api.figures import Figure
from rigrunner.api.units import from_si
from rigrunner.procedure.answers import Expected
from rigrunner_panel.view.editing import EditedView
from rigrunner_panel.view.manual import ManualView
from rigrunner_panel.view.queue import QueueView

Phase = Literal[
    "idle",
    "checking",
    "starting",
    "running",
    "asking",
    "pausing",
    "paused",
    "ending",
    "analysing",
    "manual",
    "finished",
]
Light = Literal["ok", "warn", "fail"]


class Section(BaseModel):
    """Frozen; not a finite number becomes null."""

    model_config = ConfigDict(frozen=True, extra="forbid", ser_json_inf_nan="null")


class Value(Section):
    """A value with its expanded uncertainty (95 %) where that is known."""

    value: float
    U: float | None
    unit: str


class Control(Section):
    """The client in control."""

    client: str
    name: str
    since_utc: str
    connected: bool


class JobView(Section):
    """The requested job."""

    kind: Literal["preflight", "run", "manual"]
    procedure: str
    station: str
    title: str = ""
    run: str = ""
    inputs: dict[str, str] = {}
    operator: str = ""
    partners: tuple[str, ...] = ()
    realtime: bool = True
    started_utc: str = ""


class PreflightItem(Section):
    """One check before a run."""

    kind: Literal["device", "calibration", "partner", "zero", "disk", "interlock", "procedure"]
    name: str
    state: Light
    text: str
    fix: str = ""
    override: str = ""
    asks_safe: bool = False
    """Whether a person may say that the rig is safe: it was left energised, and cannot be read."""


class Preflight(Section):
    """The checks before a run, and whether it may start."""

    procedure: str
    station: str
    done: bool
    may_start: bool
    checked_utc: str
    items: tuple[PreflightItem, ...] = ()

    @classmethod
    def of(cls, job: JobView, items: tuple[PreflightItem, ...], *, done: bool = False) -> Self:
        """Return the preflight with its items so far."""
        return cls(
            procedure=job.procedure,
            station=job.station,
            done=done,
            may_start=done and all(item.state != "fail" for item in items),
            checked_utc=job.started_utc,
            items=items,
        )


class StepView(Section):
    """A step of the plan."""

    index: int
    path: str
    phase: str
    action: str
    text: str
    point: str
    estimated_s: float
    scan_points: int = 0
    sets: dict[str, float] = {}
    """The set-point at which it leaves its drive, by 'role.drive', in SI units."""


class PlanView(Section):
    """The steps of the run, in order."""

    estimated_s: float
    steps: tuple[StepView, ...]
    drives: dict[str, str] = {}
    """The long names of the drives, by 'role.drive'."""


class Progress(Section):
    """How far the run is."""

    index: int
    states: str
    done_s: float
    estimated_s: float
    left_s: float
    recording: str = ""
    recording_s: float = 0.0
    recording_done_s: float = 0.0
    scanned: int = 0
    scan_points: int = 0


class Reading(Section):
    """One value that was read or set: in SI units, and as people see it."""

    value: float
    unit: str
    shown: float
    shown_in: str
    utc: str = ""
    """When it was read or set."""
    set: float | None = None
    """The set-point of a drive in `shown_in`; None for what is not set, or was made safe since."""

    @classmethod
    def of(cls, value: float, unit: str, written_in: str = "", utc: str = "") -> Self:
        """Return a reading; where no file states a unit, temperatures are shown in °C."""
        symbol = written_in or (usual_unit(unit) if unit else "")
        shown = from_si(value, symbol) if symbol else value
        return cls(value=value, unit=unit, shown=float(f"{shown:.9g}"), shown_in=symbol, utc=utc)

    def with_set(self, setpoint: float) -> Self:
        """Return it with a set-point in SI units."""
        return self.model_copy(update={"set": self.of(setpoint, self.unit, self.shown_in).shown})


class ChannelView(Section):
    """A channel in the unit that people see it in; `utc` is when it was read, '' for not yet."""

    name: str
    long_name: str
    si: str
    unit: str
    value: float | None = None
    utc: str = ""
    lower: float | None = None
    """Below it an interlock acts."""
    upper: float | None = None
    interval_s: float = 0.1
    """How often it is read now; what is much older is no longer live."""

    def read(self, value: float, utc: str, interval_s: float | None = None) -> ChannelView:
        """Return the channel with a new value, in its SI unit."""
        shown = Reading.of(value, self.si, self.unit).shown
        update = {"value": shown, "utc": utc, "interval_s": interval_s or self.interval_s}
        return self.model_copy(update=update)


class PromptView(Section):
    """A question that waits for its answer."""

    id: int
    step: str
    text: str
    kind: Literal["confirm", "ask"]
    choices: tuple[str, ...]
    expected: str
    unit: str
    picture: str
    accepts: SkipValidation[Expected] = Field(Expected(), exclude=True, repr=False)
    """Validates answers in the panel itself; not sent to screens."""


class PauseView(Section):
    """Where the run is paused, and how it may be resumed."""

    step: str
    point: str
    reason: str
    moving: tuple[str, ...]
    choices: tuple[str, ...]


class AlarmView(Section):
    """Something that is wrong, or was."""

    seq: int
    utc: str
    source: str
    text: str
    active: bool
    until_end: bool = False
    """Whether it was active when the run ended, and has not been monitored since."""


class CheckView(Section):
    """A named diagnostic."""

    name: str
    ok: bool
    text: str
    advice: str
    effect: str = ""
    consequence: str = ""


class ResultView(Section):
    """One value of a named result of any quantity, with its limits there."""

    name: str
    text: str
    symbol: str
    unit: str
    place: str
    """Where it holds, in words; '' for the only one."""
    value: float
    U: float | None
    readings: int
    lower: float | None = None
    """Its limits, in its unit; None if there is no such limit."""
    upper: float | None = None
    uncorrected: float | None = None
    """Its value without the correction of the analysis, if that has one."""
    is_ongoing: bool = False
    """Whether it is of the latest readings of a recording in progress, or of one not stored."""


class LiveView(Section):
    """The analysis of the recordings so far."""

    recordings: int
    final: bool
    problem: str
    taken_s: float
    verdict: str = ""
    headline: Value | None = None
    checks: tuple[CheckView, ...] = ()
    results: tuple[ResultView, ...] = ()
    figures: tuple[Figure, ...] = ()
    """Of each result over a coordinate the one that shows most, then those that analyses give."""


class AnalysingView(Section):
    """How far the analysis of the finished run is."""

    what: str
    done: int
    of: int


class FileLink(Section):
    """A file of a run, and where to get it."""

    name: str
    url: str
    size: int


class Finished(Section):
    """How the last run ended."""

    run: str
    folder: str
    outcome: str
    reason: str
    verdict: str
    headline: Value | None = None
    measurand: str = ""
    result: str = ""
    """The named result on which the verdict rests, or the only one, with its U; '' for none."""
    error: str = ""
    hint: str = ""
    problems: tuple[str, ...] = ()
    sealed: bool = False
    files: tuple[FileLink, ...] = ()
    passed_over: tuple[str, ...] = ()


class State(Section):
    """The whole truth at one moment."""

    seq: int
    latest: int
    """The number of the latest event; -1 before the first."""
    version: str
    you: str
    now_utc: str
    """The time of the panel's machine, against which the age of a value counts."""
    phase: Phase
    control: Control | None
    watchers: int
    job: JobView | None
    preflight: Preflight | None
    plan: PlanView | None
    progress: Progress | None
    readings: dict[str, Reading]
    """What is known of the rig, by 'role.name', the latest last."""
    prompt: PromptView | None
    pause: PauseView | None
    asked: Literal["", "pause", "abort", "stop", "repeat", "skip"]
    alarms: tuple[AlarmView, ...]
    live: LiveView | None
    analysing: AnalysingView | None
    finished: Finished | None
    manual: ManualView | None
    queue: QueueView
    channels: tuple[ChannelView, ...]
    editing: tuple[EditedView, ...]
