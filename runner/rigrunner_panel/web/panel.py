"""What the requests work with."""

from __future__ import annotations

import hashlib
import hmac
import secrets
import threading
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote

from rigrunner.clock import WallClock
from rigrunner.queue import Queue
from rigrunner_panel.catalogue import Catalogue
from rigrunner_panel.control import Control
from rigrunner_panel.desk import Desk
from rigrunner_panel.editing import Editing
from rigrunner_panel.errors import PanelError
from rigrunner_panel.files import ProcedureFiles
from rigrunner_panel.history import History
from rigrunner_panel.sequence import Sequence
from rigrunner_panel.view.board import Board
from rigrunner_panel.view.sections import FileLink

if TYPE_CHECKING:
    from collections.abc import Iterable
    from datetime import datetime


@dataclass(frozen=True, kw_only=True)
class Settings:
    """What `rigrunner panel` was told."""

    runs: Path = Path("runs")
    procedures: Path = Path()
    letterhead: Path = Path("letterhead")
    signing_key: Path | None = None
    """The laboratory's private key; None where nothing is signed here."""
    host: str = "127.0.0.1"
    token: str = ""
    """Without one nobody is asked who they are: then the host is this machine."""
    public_name: str = ""
    """By which name a proxy with TLS lets others in, as a browser has it: 'rig.example.org', with
    ':8443' behind it where the port is not 443."""


@dataclass(frozen=True, kw_only=True)
class Overridable:
    """The files of the last preflight, by which a start knows that they are the same."""

    procedure: str
    station: str
    digest: str
    at_s: float


@dataclass(eq=False)
class Panel:
    """One rig, one screen's worth of state, and who may do what."""

    settings: Settings
    board: Board = field(default_factory=Board)
    clock: WallClock = field(default_factory=WallClock)

    def __post_init__(self) -> None:
        self.control = Control(self.board)
        self.desk = Desk(self.board, self.settings.runs)
        self.catalogue = Catalogue(self.settings.procedures)
        self.files = ProcedureFiles(self.settings.procedures, self.catalogue)
        self.editing = Editing(self.board, self.files)
        self.history = History(self.settings.runs)
        self.queue = Queue(self.settings.runs)
        self.sequence = Sequence()
        self.archiving = threading.Lock()
        self.pictures: dict[str, Path] = {}
        self.looked_at: Overridable | None = None
        self._secret = secrets.token_bytes(32)

    def now(self) -> datetime:
        """Return the time of day."""
        return self.clock.utc()

    def ticket(self, path: str) -> str:
        """Return what lets an address be opened without the token, which a link cannot carry."""
        if not self.settings.token:
            return ""
        return hmac.new(self._secret, path.encode(), hashlib.sha256).hexdigest()[:32]

    def admits(self, path: str, ticket: str) -> bool:
        """Say whether a ticket is that of an address."""
        return bool(ticket) and hmac.compare_digest(self.ticket(path), ticket)

    def address(self, path: str) -> str:
        """Return an address with its ticket, if one is needed."""
        ticket = self.ticket(path)
        return f"{quote(path)}?ticket={ticket}" if ticket else quote(path)

    def links(self, run: str, files: Iterable[Path]) -> tuple[FileLink, ...]:
        """Return where to get files of a run."""
        return tuple(
            FileLink(
                name=each.name,
                url=self.address(f"/api/runs/{run}/files/{each.name}"),
                size=each.stat().st_size,
            )
            for each in files
        )

    def of_run(self, run: str) -> tuple[FileLink, ...]:
        """Return the files of a run with their addresses; none where it has no folder."""
        try:
            return self.links(run, self.history.files(run))
        except PanelError:
            return ()

    def picture(self, path: str) -> str:
        """Return the address of a procedure's picture, which is given out from now on."""
        key = hashlib.sha256(path.encode()).hexdigest()[:16]
        self.pictures[key] = Path(path)
        return self.address(f"/api/pictures/{key}")
