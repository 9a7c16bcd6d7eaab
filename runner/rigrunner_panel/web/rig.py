"""One rig of the panel: its station, what is done with it, its queue, and who may steer it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.queue import Queue
from rigrunner_panel.control import Control
from rigrunner_panel.desk import Desk
from rigrunner_panel.sequence import Sequence
from rigrunner_panel.view.alarms import alarms_of_rigs
from rigrunner_panel.view.board import Board

if TYPE_CHECKING:
    from rigrunner_panel.catalogue import Entry
    from rigrunner_panel.view.sections import AlarmView
    from rigrunner_panel.web.panel import Overridable, Panel


class Rig:
    """What belongs to one station alone: nothing here waits for another rig."""

    def __init__(self, panel: Panel, station: Entry) -> None:
        self.panel = panel
        self.station = station
        self.board = Board()
        self.board.wake = panel.changed
        self.control = Control(self.board)
        self.desk = Desk(self.board, panel.settings.runs, self._left_energised)
        self.queue = Queue(panel.settings.runs)
        self.sequence = Sequence()
        self.looked_at: Overridable | None = None

    @property
    def name(self) -> str:
        """The name of its station in the lists."""
        return self.station.name

    def reread(self) -> None:
        """Read the station's id and title again, where its file was changed."""
        self.station = self.panel.catalogue.reread(self.station)

    def _left_energised(self) -> tuple[AlarmView, ...]:
        """Return an alarm where this rig, or one that the panel does not show, is energised."""
        others = {each.station.id for each in self.panel.opened() if each is not self}
        return alarms_of_rigs(lambda station: station not in others - {self.station.id})
