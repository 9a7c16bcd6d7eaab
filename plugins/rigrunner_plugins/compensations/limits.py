"""What no run shows of the rig: from its description in the station, or else from settings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.signal.inputs import limited

if TYPE_CHECKING:
    from rigrunner.api.rig import RigDescription
    from rigrunner.api.uncertainty import Input
    from rigrunner_plugins.compensations.settings import InverseSettings


def stated(by_station: float | None, by_settings: float) -> float:
    """Return what the station says of its rig; the method's setting where it says nothing."""
    return by_settings if by_station is None else by_station


def known(settings: InverseSettings, rig: RigDescription) -> InverseSettings:
    """Return the settings with what the station knows better of its rig."""
    names = ("inertia_mismatch", "support_load_dependence", "support_load_growth")
    better = {name: stated(getattr(rig, name), getattr(settings, name)) for name in names}
    return settings.model_copy(update=better)


def load(rig: RigDescription) -> Input:
    """Return the relative error of the load: friction is proportional to it (Coulomb)."""
    return limited("load", rig.load_tolerance, "1")
