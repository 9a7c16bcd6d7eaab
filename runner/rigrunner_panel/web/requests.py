"""The bodies of requests."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from rigrunner.api.texts import plain
from rigrunner.yamlfile.reader import MAX_BYTES

Name = Annotated[str, Field(min_length=1, max_length=200)]
Words = Annotated[str, Field(max_length=1000), AfterValidator(plain)]
Person = Annotated[str, Field(min_length=1, max_length=100, pattern=r"\S"), AfterValidator(plain)]
Reason = Annotated[str, Field(min_length=1, max_length=1000, pattern=r"\S"), AfterValidator(plain)]
MaybePerson = Annotated[str, Field(max_length=100), AfterValidator(plain)]
Inputs = Annotated[dict[Name, Words], Field(max_length=200)]
Order = Annotated[dict[Name, Words], Field(max_length=50)]
Partners = Annotated[dict[Name, Name], Field(max_length=20)]
"""Partner runs by name, in place of those found automatically."""


class Body(BaseModel):
    """Strict; unknown fields are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Nothing(Body):
    """An empty object."""


class Pair(Body):
    """A procedure on a station, by their names in the lists."""

    procedure: Name
    station: Name


ProcedureText = Annotated[str, Field(max_length=MAX_BYTES)]


class AskPlan(Pair):
    """A plan; with a text, of that instead of the procedure's file."""

    text: ProcedureText | None = None


class EditProcedure(Body):
    """A procedure that is being edited, and by whom."""

    procedure: Name
    by: MaybePerson = ""


class CheckText(Body):
    """The text of a procedure, and a station that it is to fit."""

    procedure: Name
    text: ProcedureText
    station: Annotated[str, Field(max_length=200)] = ""


class CompareText(Body):
    """The text of a procedure, and what it is compared with.

    `file` is the file as it is now; `reference` the approved text, or else that of the last run.
    """

    procedure: Name
    text: ProcedureText
    against: Literal["file", "reference"] = "reference"


class SaveProcedure(Body):
    """A text for a file that has that digest; without one, for a new file."""

    procedure: Name
    text: ProcedureText
    digest: Annotated[str, Field(pattern="^([0-9a-f]{64})?$")] = ""
    by: Person


class ApproveProcedure(Body):
    """A procedure as it stands: `sha256` is that of the text that was seen, with what it calls."""

    procedure: Name
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    by: Person


class CheckInput(Body):
    """An answer to an input, as far as it is typed."""

    procedure: Name
    input: Name
    text: Words


class TakeControl(Body):
    """Who takes control."""

    name: Person
    take_over: bool = False


class StartPreflight(Pair):
    """A procedure and a station to check before a run."""

    partners: Partners = {}
    safe: Words = ""
    """Why a rig that was left energised is safe, as seen or done by a person."""


class Overridden(Body):
    """Overrides of the preflight, by the names in its items, with person and reason."""

    what: Annotated[list[Name], Field(min_length=1, max_length=100)]
    by: Person
    reason: Reason


class StartRun(Pair):
    """A run. The operator is asked for missing inputs."""

    inputs: Inputs = {}
    operator: MaybePerson = ""
    partners: Partners = {}
    realtime: bool = True
    override: Overridden | None = None
    entry: int | None = None
    """The entry of the queue that is started."""


class ResumeRun(Body):
    """How an interrupted run is resumed."""

    realtime: bool = True


class AddEntries(Pair):
    """Specimens for the queue: one a line, or a CSV whose first line names inputs.

    Without a list it is one entry, of the inputs alone.
    """

    list: Annotated[str, Field(max_length=60_000)] = ""
    inputs: Inputs = {}
    operator: MaybePerson = ""
    partners: Partners = {}
    realtime: bool = True
    again: Words = ""
    """Why specimens that have a run are tested again."""


class ProposeEntries(AddEntries):
    """Specimens that a person releases first, and who or which program proposes them.

    Without `by` it is the person in control; a program has to state its name.
    """

    by: MaybePerson = ""


class OneEntry(Body):
    """An entry of the queue by its number; for a start, the next one where none is named."""

    entry: int = 0


class EntryBecause(Body):
    """An entry of the queue, and why."""

    entry: int
    reason: Reason


class Move(Body):
    """An entry, and the one that it is put in front of; last where that is null."""

    entry: int
    before: int | None = None


class SetAutomatic(Body):
    """Whether runs of the queue may start by themselves."""

    on: bool


class OpenManual(Pair):
    """A session by hand, with the channels and the analysis of a procedure."""

    operator: MaybePerson = ""
    partners: Partners = {}
    realtime: bool = True
    override: Overridden | None = None


class GiveAnswer(Body):
    """An answer to the prompt of that id."""

    prompt: int
    text: Words


class Why(Body):
    """A reason that may be left out."""

    reason: Words = ""


class BecauseOf(Body):
    """A reason that is needed."""

    reason: Reason


class Remark(Body):
    """A note."""

    text: Reason


class SetDrive(Body):
    """A set-point with its unit: '10 Hz'."""

    drive: Name
    value: Annotated[str, Field(min_length=1, max_length=60)]


class RecordPoint(Body):
    """How many cycles are recorded."""

    cycles: Annotated[int, Field(ge=3, le=1000)] = 10


class AskCertificate(Body):
    """What is needed to issue a certificate."""

    authorised_by: Reason
    role: Words = ""
    order: Order = {}
    language: Annotated[str, Field(max_length=10)] = ""
    not_for_certification: bool = False
    further_copy: Words = ""
    """Why there is to be a further specimen on a run that has one."""


class AskAmendment(Body):
    """What changes in a certificate, why, and who authorises it."""

    reason: Reason
    authorised_by: Reason
    role: Words = ""
    order: Order = {}


class AskWithdrawal(Body):
    """Who withdraws a certificate, and why."""

    reason: Reason
    by: Person


class AskSignature(Body):
    """Who signs; the passphrase of the key, if it has one."""

    by: Person
    passphrase: Annotated[str, Field(max_length=500)] = ""
