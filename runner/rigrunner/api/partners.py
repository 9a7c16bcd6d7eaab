"""Partner runs: other runs that an analysis uses besides the one that it analyses.

A dark reading for a responsivity, a reference specimen for a comparison, an empty oven for the heat
lost: settings ask for one as a `PartnerRun`, the analysis lists it in its `Requirements` and gets
the data as `run.partners[name]`, online, of a stored run and in a batch.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from pydantic import AfterValidator, Field

from rigrunner.api.analysis.requirements import LATEST, STATION, NeededRun
from rigrunner.api.member import NAME
from rigrunner.api.names import Identifier
from rigrunner.api.settings import Duration, ListOf, Settings

if TYPE_CHECKING:
    from rigrunner.api.analysis import NeededChannel

_HOUR_S = 3600.0


def _name(text: str) -> str:
    NeededRun(name=text, key=())  # refuses what cannot be a name
    return text


PartnerName = Annotated[str, Field(pattern=f"^{NAME}$"), AfterValidator(_name)]
"""The name of a partner run, such as 'dark'."""


class PartnerRun(Settings):
    """Selects a partner run, and what it must have in common with this run."""

    from_: Annotated[str, Field(alias="from", min_length=1)] = LATEST
    """'latest', or a run by its folder or name."""
    procedure: Identifier | None = None
    """The id of its procedure."""
    max_age: Annotated[Duration, Field(gt=0)] = 8 * _HOUR_S
    """Longest time between the start of the partner run and of this one."""
    same: ListOf[str] = (STATION,)
    """What both runs must share: 'station', and keys of the rig."""

    def needed(
        self,
        name: str,
        key: tuple[str | int, ...],
        *,
        after: bool = False,
        channels: tuple[NeededChannel, ...] = (),
        at: tuple[str, ...] = (),
        within: float = 1e-6,
    ) -> NeededRun:
        """Return it as a requirement under a name; `key` is its place in the settings."""
        return NeededRun(
            name=name,
            key=key,
            procedure=self.procedure or "",
            run=LATEST if after else self.from_,
            max_age_s=self.max_age,
            same=tuple(self.same),
            after=after,
            channels=channels,
            at=at,
            within=within,
        )
