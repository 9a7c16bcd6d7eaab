"""Entry point of the process that controls the rig: does one job and exits."""

from __future__ import annotations

import os
import sys
import traceback
from typing import TYPE_CHECKING

from rigrunner.api.errors import InvalidFileError, RigrunnerError
from rigrunner.engine import StopNow
from rigrunner_panel.errors import error_code
from rigrunner_panel.jobs.manual import manual
from rigrunner_panel.jobs.preflight import preflight
from rigrunner_panel.jobs.run import run
from rigrunner_panel.process.channel import Channel
from rigrunner_panel.process.link import Commands, Link, Sender
from rigrunner_panel.process.messages import Ended, Failed
from rigrunner_panel.process.switch import Switch

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner_panel.process.messages import Job

_JOBS: dict[str, Callable[[Job, Link], Ended]] = {
    "preflight": preflight,
    "run": run,
    "manual": manual,
}


def main() -> None:
    """Read the job from stdin, do it, and report its progress on stdout."""
    switch = Switch()
    switch.install()
    channel = Channel.on_stdout()
    link = Link(Commands(channel, switch), Sender(channel), switch)
    job = channel.receive()
    link.commands.start()
    link.sender.send(_do(job, link))
    link.sender.close()
    sys.stderr.flush()
    os._exit(0)  # all is sent; the thread that listens to the panel would delay the end


def _do(job: Job, link: Link) -> object:
    try:
        with link.switch.interruptible():
            return _JOBS[job.view.kind](job, link)
    except StopNow as stop:
        return Failed(f"{stop.reason}, before the run began", code="aborted")
    except InvalidFileError as error:
        return Failed(str(error), error.hint, "invalid", error.problems)
    except RigrunnerError as error:
        return Failed(error.message, error.hint, error_code(error))
    except Exception as error:  # noqa: BLE001  (a bug, of ours or of a plugin: the panel says so)
        trace = "".join(traceback.format_exception(error))
        return Failed(f"{type(error).__name__}: {error}", trace=trace)


if __name__ == "__main__":
    main()
