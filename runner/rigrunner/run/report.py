"""Writes the report of a stored run by a report format."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rigrunner.analysis.document import document
from rigrunner.api.analysis.requirements import partner_words
from rigrunner.api.events import (
    Alarm,
    Answer,
    Event,
    Intervention,
    LimitMissed,
    Note,
    Prompt,
    RunEnded,
)
from rigrunner.api.hooks import ReportFormatRecord
from rigrunner.api.progress import unseen
from rigrunner.api.results import ReportInput
from rigrunner.run.decisions import later_decisions
from rigrunner.run.log import event_text
from rigrunner.run.stored import analyse_stored
from rigrunner.runfile import read_with_truth
from rigrunner.runfile.durable import write_whole

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from rigrunner.api.progress import Progress
    from rigrunner.api.results import Result
    from rigrunner.registry import Registry
    from rigrunner.runfile import StoredRun
    from rigrunner.runfile.reading import Truth

OVERRIDE = "override"
DEFAULT_FORMAT = "html"


@dataclass(frozen=True, eq=False)
class AnalysedRun:
    """A run that was read and analysed: what its report shows."""

    stored: StoredRun
    truth: Truth
    result: Result
    document: Mapping[str, Any]
    """The content of `result.json`."""

    @classmethod
    def of(
        cls, stored: StoredRun, truth: Truth, registry: Registry, progress: Progress
    ) -> AnalysedRun:
        """Analyse a run that was read."""
        result = analyse_stored(stored, registry, progress=progress)
        return cls(stored, truth, result, document(result))


def write_report(
    path: Path,
    registry: Registry,
    *,
    analysed: AnalysedRun | None = None,
    out: Path | None = None,
    kind: str = DEFAULT_FORMAT,
    progress: Progress = unseen,
) -> Path:
    """Write the report of a run and return its path; the same run gives the same bytes.

    Pass a run that is `analysed` already, so that it is not read again. `out` is by default
    `report` with the suffix of the format, in the folder of the run. Raises DataError and
    PluginError.
    """
    record = registry.find("report_format", kind).record
    assert isinstance(record, ReportFormatRecord)  # noqa: S101  (guaranteed by the kind)
    folder = path if path.is_dir() else path.parent
    target = out or folder / f"report{record.suffix}"
    render = registry.make("report_format", kind, {})
    if analysed is None:
        analysed = AnalysedRun.of(*read_with_truth(path), registry, progress)
    write_whole(target, render(report_input(analysed, folder)))
    return target


def report_input(analysed: AnalysedRun, folder: Path) -> ReportInput:
    """Return the input of a report format for a run in a folder."""
    stored, result = analysed.stored, analysed.result
    return ReportInput(
        result=result,
        document=analysed.document,
        truth=analysed.truth,
        provenance=_provenance(stored, result),
        events=(*_partner_overrides(stored.partners), *_outline_lines(stored)),
        later_decisions=tuple(decision.summary for decision in later_decisions(stored, folder)),
    )


def _provenance(stored: StoredRun, result: Result) -> dict[str, str]:
    header = stored.header
    return {
        "run": header.run_id,
        "digest of the recordings (SHA-256)": stored.digest,
        "procedure": f"{header.procedure_id} revision {header.procedure_revision}",
        "station": header.station_id,
        **{
            what: text
            for name, run in result.run.partners.items()
            for what, text in (
                (partner_words(name), run.run_id),
                (f"digest of the {partner_words(name)} (SHA-256)", run.digest),
            )
        },
        **header.provenance,
        **{f"import, {name}": text for name, text in header.imported.items()},
        **{f"salvage, {name}": text for name, text in header.salvaged.items()},
    }


def _outline_lines(stored: StoredRun) -> Iterator[dict[str, str]]:
    """Yield questions, answers, actions and problems in order."""
    question = ""
    for event in stored.outline:
        match event:
            case Prompt():
                question = event.text
            case Answer():
                yield _line(event, "answer", f"{question} — {event.text} ({event.by})")
            case Intervention():
                yield _line(event, event.action, event_text(event))
            case LimitMissed():  # before its base class, Alarm or Note
                yield _line(event, "out of limits", event_text(event))
            case Alarm():
                yield _line(event, "alarm", event_text(event))
            case Note():
                yield _line(event, "note", event_text(event))
            case RunEnded():
                yield _line(event, "end", event_text(event))


def _partner_overrides(partners: Mapping[str, StoredRun]) -> Iterator[dict[str, str]]:
    """Yield the overrides of partner runs, on which the result depends too."""
    for name, run in partners.items():
        for event in run.outline:
            if isinstance(event, Intervention) and event.action == OVERRIDE:
                yield _line(event, event.action, f"{partner_words(name)}: {event_text(event)}")


def _line(event: Event, kind: str, text: str) -> dict[str, str]:
    return {"utc": event.utc, "kind": kind, "text": text}
