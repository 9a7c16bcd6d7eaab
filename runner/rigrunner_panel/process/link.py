"""What a job has to do with the panel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rigrunner_panel.process.inbox import Inbox
    from rigrunner_panel.process.outbox import Outbox
    from rigrunner_panel.process.switch import Switch


@dataclass(frozen=True)
class Link:
    """Both directions, and the switch that ends the job."""

    inbox: Inbox
    outbox: Outbox
    switch: Switch

    def send(self, message: object) -> None:
        """Tell the panel something."""
        self.outbox.send(message)
