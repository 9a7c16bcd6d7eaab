"""`rigrunner panel`: serves the panel until Ctrl-C, and leaves no rig unsafe."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import os
import signal
import socket
import webbrowser
from typing import TYPE_CHECKING

import uvicorn

from rigrunner.api.errors import ExitCode, UsageError
from rigrunner.ending import ENDING, HANGUPS, Consoles, signal_name, take_signals
from rigrunner_panel.errors import PanelError
from rigrunner_panel.web.app import make_app
from rigrunner_panel.web.connections import Bounded
from rigrunner_panel.web.panel import Panel
from rigrunner_panel.web.security import check_public_name, is_loopback

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from types import FrameType

    from rigrunner_panel.web.panel import Settings

LEAST_TOKEN = 16
_NO_TOKEN = "give one: --token, or the variable RIGRUNNER_PANEL_TOKEN"  # noqa: S105  (a hint)
_GRACE_S = 3
_LOOK_S = 0.1
_AT_ONCE = 64
"""Most connections that may wait to be accepted."""


def serve(
    settings: Settings, port: int, echo: Callable[[str], None], *, open_browser: bool
) -> ExitCode:
    """Serve until Ctrl-C, SIGTERM or a closed terminal.

    A run in progress is aborted and the rig made safe before the end.

    Raises UsageError for a host other than this computer without a token, and if the port cannot be
    used.
    """
    if not is_loopback(settings.host) and not settings.token:
        message = f"--host {settings.host} lets other machines in, and there is no token"
        raise UsageError(message, hint=_NO_TOKEN)
    if settings.public_name:
        check_public_name(settings.public_name)
        if not settings.token:
            message = f"--public-name {settings.public_name} lets others in, and there is no token"
            raise UsageError(message, hint=_NO_TOKEN)
    if settings.token and len(settings.token) < LEAST_TOKEN:
        hint = "python -c 'import secrets; print(secrets.token_urlsafe())' makes one"
        raise UsageError(f"the token has fewer than {LEAST_TOKEN} characters", hint=hint)
    panel = Panel(settings=settings)
    for name in set(settings.stations) - {rig.name for rig in panel.open_rigs()}:
        hint = f"name it as seen from {settings.procedures}, or a shipped one"
        raise UsageError(f"there is no station '{name}'", hint=hint)
    config = server_config(panel)
    listening = _bound(settings.host, port)
    address = _address(settings, listening.getsockname()[1])
    ending = Ending(panel, echo)
    try:
        with ending.signals():  # before the address is shown: its reader may end the panel
            echo(f"Panel: {address}")
            if settings.public_name:
                echo(f"Through the proxy: https://{settings.public_name}/#token={settings.token}")
            if open_browser:
                webbrowser.open(address)
            asyncio.run(_serve_until_end(_Server(config), listening, ending))
    finally:
        for rig in panel.open_rigs():
            rig.desk.close()
    return ending.exit_code


def server_config(panel: Panel) -> uvicorn.Config:
    """Return the configuration of the server."""
    return uvicorn.Config(
        make_app(panel),
        log_level="warning",
        http=Bounded,
        backlog=_AT_ONCE,
        ws="websockets-sansio",
        ws_max_size=4096,
        timeout_graceful_shutdown=_GRACE_S,
        server_header=False,
    )


class Ending:
    """Handles Ctrl-C: without a run it ends the panel; with a run it aborts the run, then ends.

    SIGTERM is handled in the same way. A closed terminal may send several signals, from the system
    and the shell: it only ever aborts.
    """

    def __init__(self, panel: Panel, echo: Callable[[str], None]) -> None:
        self._panel = panel
        self._echo = echo
        self._consoles = Consoles()
        self._presses = 0
        self._number: int = signal.SIGINT
        self._aborted = False
        self.is_requested = False

    @property
    def exit_code(self) -> ExitCode:
        """The exit code of the command."""
        return ExitCode.INTERRUPTED if self._aborted else ExitCode.PASS

    @contextlib.contextmanager
    def signals(self) -> Iterator[None]:
        """Handle the signals that end the program, and restore the former handlers afterwards."""
        former = take_signals(ENDING, self._take)
        former[signal.SIGINT] = signal.signal(signal.SIGINT, self._take)
        try:
            yield
        finally:
            for number, handler in former.items():
                signal.signal(number, handler)

    def advance(self) -> bool:
        """Handle the signals since the last call; return whether the server must end."""
        if not self.is_requested:
            return False
        busy = [rig.desk for rig in self._panel.open_rigs() if rig.desk.is_busy]
        if not busy:
            return True
        if self._presses and not self._aborted:
            self._aborted, self._presses = True, 0
            for desk in busy:
                self._say(
                    f"{desk.name} is running. Aborting: teardown, then the rig is made safe."
                    " Ctrl-C stops at once."
                )
                with contextlib.suppress(PanelError):  # it has ended just now
                    desk.abort(*self._who())
        elif self._presses:
            self._presses = 0
            self._say("Stopping now: no teardown, the rig is made safe. Please wait.")
            for desk in busy:
                desk.stop(*self._who())
        return False

    def _take(self, number: int, _frame: FrameType | None) -> None:
        self._consoles.silence_closed()
        if number in HANGUPS and self.is_requested:
            return
        self.is_requested, self._number = True, number
        self._presses += 1

    def _who(self) -> tuple[str, str]:
        """Return who ends the run, and by which signal."""
        if self._number == signal.SIGINT:
            return "keyboard", "Ctrl-C in the panel's terminal"
        return "signal", f"{signal_name(self._number)} to the panel"

    def _say(self, text: str) -> None:
        """Print a message at the terminal; a closed terminal is not an error."""
        with contextlib.suppress(OSError):
            self._echo(text)


class _Server(uvicorn.Server):
    """A server that does not handle signals itself: they do not end it during a run."""

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Capture no signals."""
        yield


async def _serve_until_end(server: _Server, listening: socket.socket, ending: Ending) -> None:
    """Serve until the end is requested and no run is in progress."""
    work = asyncio.create_task(server.serve(sockets=[listening]))
    while not work.done() and not await asyncio.to_thread(ending.advance):
        await asyncio.wait({work}, timeout=_LOOK_S)
    server.should_exit = True
    await work


_OF_THE_PORT = {
    errno.EADDRINUSE: "another panel may be open there; --port 0 uses any free port",
    errno.EACCES: "ports below 1024 need administrator rights; --port 0 uses any free port",
}
_OF_THE_HOST = "--host takes an address of this machine, such as 127.0.0.1"


def _bound(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        return socket.create_server((host, port), family=family)
    except (OSError, OverflowError) as error:
        number = error.errno if isinstance(error, OSError) else None
        hint = _OF_THE_PORT.get(number or 0, _OF_THE_HOST)
        text = os.strerror(number) if number in _OF_THE_PORT else str(error).partition(" (while")[0]
        raise UsageError(f"cannot listen on {host}, port {port}: {text}", hint=hint) from error


def _address(settings: Settings, port: int) -> str:
    """Return the address to open; the token follows '#', which browsers do not send to servers."""
    shown = settings.host if is_loopback(settings.host) else socket.gethostname()
    host = f"[{shown}]" if ":" in shown else shown
    token = f"#token={settings.token}" if settings.token else ""
    return f"http://{host}:{port}/{token}"
