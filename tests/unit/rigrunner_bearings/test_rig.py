"""The keys of a rig that a station of the bearings may have."""

from __future__ import annotations

from rigrunner.registry import load_registry


def test_what_ships_declares_the_rig_of_bearings():
    assert {"mandrel", "eccentric"} <= set(load_registry().rig_model().model_fields)
