"""The rigs, and what they have in common."""

from __future__ import annotations

import hashlib
import hmac
import secrets
import threading
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote

from rigrunner.api.errors import DataError
from rigrunner.clock import WallClock
from rigrunner.queue import Queue
from rigrunner_panel.catalogue import Catalogue
from rigrunner_panel.control import Control, short_name
from rigrunner_panel.desk import Desk
from rigrunner_panel.editing import Editing
from rigrunner_panel.errors import PanelError
from rigrunner_panel.files import ProcedureFiles
from rigrunner_panel.history import History
from rigrunner_panel.sequence import Sequence
from rigrunner_panel.view.alarms import alarms_of_rigs
from rigrunner_panel.view.board import Board
from rigrunner_panel.view.sections import FileLink
from rigrunner_panel.web.operation import API

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from datetime import datetime

    from rigrunner_panel.catalogue import Entry
    from rigrunner_panel.view.editing import EditedView
    from rigrunner_panel.view.sections import AlarmView


@dataclass(frozen=True, kw_only=True)
class Settings:
    """The options of `rigrunner panel`."""

    runs: Path = Path("runs")
    procedures: Path = Path()
    stations: tuple[str, ...] = ()
    """Names of the stations that may be used; all of them if empty."""
    letterhead: Path = Path("letterhead")
    signing_key: Path | None = None
    """The laboratory's private key; None where nothing is signed here."""
    host: str = "127.0.0.1"
    token: str = ""
    """Without a token no login is needed; the host must be this machine then."""
    public_name: str = ""
    """The host name of a proxy with TLS, as a browser has it: 'rig.example.org', with ':8443'
    behind it if the port is not 443."""


@dataclass(frozen=True, kw_only=True)
class CheckedFiles:
    """The files of the last preflight, to check at a start that they are still the same."""

    digest: str
    at_s: float


class Rig:
    """What belongs to one station alone: nothing here waits for another rig."""

    def __init__(self, panel: Panel, station: Entry) -> None:
        self.panel = panel
        self.station = station
        self.board = Board()
        self.board.wake = panel.notify
        self.control = Control(self.board)
        self.desk = Desk(self.board, panel.settings.runs, self._left_energised)
        self.queue = Queue(panel.settings.runs)
        self.sequence = Sequence()
        self.checked_files: CheckedFiles | None = None

    @property
    def name(self) -> str:
        """The name of its station in the lists."""
        return self.station.name

    def reread(self) -> None:
        """Read the station's id and title again, where its file was changed."""
        self.station = self.panel.catalogue.reread(self.station)

    def _left_energised(self) -> tuple[AlarmView, ...]:
        """Return an alarm where this rig, or one that the panel does not show, is energised."""
        others = {rig.station.id for rig in self.panel.open_rigs() if rig is not self}
        return alarms_of_rigs(lambda station: station not in others - {self.station.id})


@dataclass(eq=False)
class Panel:
    """The rigs of a laboratory, and what they have in common: its files and its stored runs."""

    settings: Settings
    clock: WallClock = field(default_factory=WallClock)

    def __post_init__(self) -> None:
        self.catalogue = Catalogue(self.settings.procedures, self.settings.stations)
        self.files = ProcedureFiles(self.settings.procedures, self.catalogue)
        self.editing = Editing(self._publish_editing, self.files)
        self.history = History(self.settings.runs)
        self.archiving = threading.Lock()
        self.pictures: dict[str, Path] = {}
        self.wake: Callable[[], None] = lambda: None
        """The functions that `notify` calls: they update the screens."""
        self._rigs: dict[str, Rig] = {}
        self._opening = threading.Lock()
        self._secret = secrets.token_bytes(32)
        self.rigs()

    def notify(self) -> None:
        """Take note, in any thread, that something of a rig has changed."""
        self.wake()

    def open_rigs(self) -> tuple[Rig, ...]:
        """Return the rigs that were shown or used since the start, by name; reads no file."""
        return tuple(rig for _, rig in sorted(self._rigs.copy().items()))

    def rigs(self) -> tuple[Rig, ...]:
        """Return all rigs: those named or of the lab, others in use, and those with a queue."""
        with suppress(DataError):  # shown with the queue of its station
            queued = Queue(self.settings.runs).stations()
            self._open(name for name in queued if name not in self._rigs)
        self._open(self.catalogue.rigs())
        return self.open_rigs()

    def rig(self, name: str) -> Rig:
        """Return the rig of that station; raise PanelError for one that is not in the lists."""
        rig = self._rigs.get(name)  # without the lock, and without looking for files
        if rig is not None:
            return rig
        with self._opening:
            if name not in self._rigs:
                self._rigs[name] = Rig(self, self.catalogue.station(name))
            return self._rigs[name]

    def only_rig(self) -> Rig | None:
        """Return the rig if there is only one, or else None."""
        rigs = self.open_rigs()
        return rigs[0] if len(rigs) == 1 else None

    def steering_name(self, client: str) -> str:
        """Return the name of a client that has control of a rig; raise PanelError for another."""
        rigs = self.open_rigs()
        controlled = [rig for rig in rigs if rig.control.holds(client)]
        others = [rig for rig in rigs if rig.board.get("control") is not None]
        for rig in (*controlled, *others, *rigs):
            return rig.control.require(client)
        raise PanelError(
            403, "not_in_control", "nobody has control", "take it first: POST /api/v1/control"
        )

    def name_of(self, client: str) -> str:
        """Return how a client is called on record: by name if it has control of a rig."""
        names = (rig.control.holds(client) for rig in self.open_rigs())
        default = f"panel client {short_name(client)}" if client else "panel"
        return next((name for name in names if name), default)

    def tick(self) -> None:
        """Look for what other programs changed in procedures that are edited."""
        self.editing.tick(
            lambda client: any(rig.control.is_connected(client) for rig in self.open_rigs()),
            self.now(),
        )

    def _publish_editing(self, views: tuple[EditedView, ...]) -> None:
        for rig in self.open_rigs():
            rig.board.put(editing=views)

    def _open(self, names: Iterable[str]) -> None:
        for name in names:
            with suppress(PanelError):  # there is no such station any more
                self.rig(name)

    def now(self) -> datetime:
        """Return the time of day."""
        return self.clock.utc()

    def ticket(self, path: str) -> str:
        """Return a ticket that opens an address without the token, which a link cannot carry."""
        if not self.settings.token:
            return ""
        return hmac.new(self._secret, path.encode(), hashlib.sha256).hexdigest()[:32]

    def admits(self, path: str, ticket: str) -> bool:
        """Return whether a ticket is that of an address."""
        return bool(ticket) and hmac.compare_digest(self.ticket(path).encode(), ticket.encode())

    def address(self, path: str) -> str:
        """Return an address with its ticket, if one is needed."""
        ticket = self.ticket(path)
        return f"{quote(path)}?ticket={ticket}" if ticket else quote(path)

    def links(self, run: str, files: Iterable[Path]) -> tuple[FileLink, ...]:
        """Return where to get files of a run."""
        return tuple(
            FileLink(
                name=path.name,
                url=self.address(f"{API}/runs/{run}/files/{path.name}"),
                size=path.stat().st_size,
            )
            for path in files
        )

    def run_links(self, run: str) -> tuple[FileLink, ...]:
        """Return the files of a run with their addresses; none where it has no folder."""
        try:
            return self.links(run, self.history.files(run))
        except PanelError:
            return ()

    def picture(self, path: str) -> str:
        """Return the address of a procedure's picture, which is given out from now on."""
        key = hashlib.sha256(path.encode()).hexdigest()[:16]
        self.pictures[key] = Path(path)
        return self.address(f"{API}/pictures/{key}")
