"""Report a finished run: its results, its error, and its location."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rigrunner.analysis.document import document
from rigrunner.api.errors import RigrunnerError
from rigrunner.api.events import Outcome
from rigrunner.api.summaries import pairs
from rigrunner.cli.boundary import show_bug, show_error
from rigrunner.cli.output import message, result, result_json, unsafe_rig
from rigrunner.cli.summary import identity, summary

if TYPE_CHECKING:
    from rigrunner.run.finish import FinishedRun


def show_finished(finished: FinishedRun, *, as_json: bool = False) -> None:
    """Print the result and the location on stdout, and an error on stderr."""
    content = None if finished.result is None else document(finished.result)
    if as_json and content is not None:
        result_json(content)
    elif content is not None:
        result(f"{identity(content)}\n\n{summary(content)}\n")
    _show_end(finished)
    show = message if as_json else result
    show(f"{places(finished)}\n")


def _show_end(finished: FinishedRun) -> None:
    error = finished.error
    if isinstance(error, RigrunnerError):
        show_error(error)
    elif isinstance(error, KeyboardInterrupt):
        message("Interrupted.")
    elif isinstance(error, Exception):
        show_bug(error)
    if error is not None:
        message(f"The run was {_end_text(finished)}.")
    if finished.unsafe:
        message(unsafe_rig(finished.unsafe))
    if finished.waits:
        message(
            "It waits for the partner run after it: make that run, then"
            f" 'rigrunner resume {_run_argument(finished.folder)}' makes the result."
        )
    elif not finished.sealed:
        name = _run_argument(finished.folder)
        message(
            f"It is not sealed. Fix the cause; then 'rigrunner resume {name}' resumes the run,"
            f" and 'rigrunner recover {name}' closes it as it is."
        )
    elif error is not None and finished.outcome is Outcome.COMPLETED and finished.result is None:
        message(
            f"Its data are kept: 'rigrunner reanalyse {finished.folder} --analysis FILE --out"
            " FOLDER' analyses them with other settings."
        )
    for text in finished.passed_over:
        message(f"The run continued after a failure: {text}")


def _run_argument(folder: Path) -> str:
    """Return the argument by which a command finds a run: its name, if it is in ./runs."""
    return folder.name if folder.parent == Path("runs") else str(folder)


def _end_text(finished: FinishedRun) -> str:
    if finished.outcome is Outcome.ABORTED:
        return "aborted"
    if finished.outcome is Outcome.ERROR:
        return "ended by an error"
    missing = "analysed" if finished.result is None else "reported"
    return f"{finished.outcome}, but could not be {missing}"


def places(finished: FinishedRun) -> str:
    """Return the paths of the run's folder, and of its report if it has one."""
    report = [("report", str(finished.report))] if finished.report else []
    return pairs([("run folder", str(finished.folder)), *report])
