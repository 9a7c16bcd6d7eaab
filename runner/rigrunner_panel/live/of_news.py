"""What the process that has the rig tells, as sections of the state."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from rigrunner_panel.view.sections import Finished, PauseView, PreflightItem, PromptView

if TYPE_CHECKING:
    from rigrunner.engine import Paused
    from rigrunner_panel.process.news import Asked, Failed
    from rigrunner_panel.view.sections import FileLink


class Links(Protocol):
    """Knows under which addresses a screen can get files."""

    def picture(self, path: str) -> str:
        """Return the address of a procedure's picture."""
        ...

    def of_run(self, run: str) -> tuple[FileLink, ...]:
        """Return the files of a run with their addresses."""
        ...


def pause_view(paused: Paused) -> PauseView:
    """Return where the run is paused, why, and what may be chosen."""
    return PauseView(
        step=paused.step,
        point=paused.point,
        reason=paused.reason,
        moving=paused.moving,
        choices=tuple(str(each) for each in paused.choices),
    )


def prompt_view(asked: Asked, links: Links) -> PromptView:
    """Return what a person is asked, and what is an answer to it."""
    return PromptView(
        id=asked.number,
        step=asked.step,
        text=asked.text,
        kind=asked.kind,
        choices=asked.expected.choices,
        expected=asked.expected.words,
        unit=asked.expected.unit,
        picture=links.picture(asked.picture) if asked.picture else "",
    )


def failed_run(failed: Failed, run: str) -> Finished:
    """Return the end of a job that could not be begun, or that a bug ended."""
    return Finished(
        run=run,
        folder="",
        outcome="aborted" if failed.code == "aborted" else "error",
        reason=failed.message,
        verdict="",
        error=failed.trace or failed.message,
        hint=failed.hint,
        problems=tuple(str(each) for each in failed.problems),
    )


def failed_item(failed: Failed) -> PreflightItem:
    """Return the same as a part of the preflight."""
    text = "; ".join(str(each) for each in failed.problems) or failed.message
    return PreflightItem(kind="procedure", name="files", state="fail", text=text, fix=failed.hint)
