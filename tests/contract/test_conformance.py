"""Every plugin that ships goes through the conformance kit, each check a test of its own."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from rigrunner.api.errors import PluginError
from rigrunner.registry import load_registry
from rigrunner.testing import checks, conform, subject

REGISTRY = load_registry()


def _can_be_tried(plugin):
    try:
        REGISTRY.validated(plugin.kind, plugin.record.name, plugin.record.trial)
    except PluginError:
        return False
    return True


CASES = [
    (plugin.kind, plugin.record.name, check)
    for plugin in filter(_can_be_tried, REGISTRY.plugins)
    for check in checks(plugin.kind)
]
NOT_ALONE = [
    (plugin.kind, plugin.record.name) for plugin in REGISTRY.plugins if not _can_be_tried(plugin)
]
"""These need files or an instrument; tests of their own take the kit to them."""


@lru_cache(maxsize=2)
def tried(kind, name, folder):
    """Return the plugin, remembered: what most checks of a compensation look at takes a second."""
    return subject(kind, name, registry=REGISTRY, folder=folder)


@pytest.mark.parametrize(
    ("kind", "name", "check"), CASES, ids=[f"{kind}-{name}-{check}" for kind, name, check in CASES]
)
def test_it_conforms(kind, name, check, tmp_path):
    why_not = conform(tried(kind, name, tmp_path if kind == "device" else None), check)
    if why_not:
        pytest.skip(why_not)


@pytest.mark.parametrize(("kind", "name"), NOT_ALONE)
def test_what_cannot_be_tried_alone_says_what_it_needs(kind, name):
    with pytest.raises(PluginError, match="give settings with which it can be tried"):
        subject(kind, name, registry=REGISTRY)


def test_most_can_be_tried_alone():
    assert len(NOT_ALONE) <= len(REGISTRY.plugins) / 3
    assert {kind for kind, _ in NOT_ALONE} <= {"device"}


class TestReplay:
    """With files as a test makes them, by the kit's plugin of pytest."""

    @pytest.fixture
    def conformance_settings(self, tmp_path):
        angle = np.sin(np.arange(40_000) / 50)
        rows = np.c_[angle, 2 * angle]
        np.savetxt(tmp_path / "swing.csv", rows, delimiter=",", header="a,t", comments="")
        tmp_path.joinpath("manifest.yaml").write_text(MANIFEST)
        columns = {
            "angle": {"column": "a", "unit": "deg"},
            "torque": {"column": "t", "unit": "N·m"},
        }
        return {"folder": str(tmp_path), "rate": "10 kHz", "channels": columns}

    @pytest.mark.conformance("device", "replay")
    def test_it_conforms(self, conformance):
        conformance()


MANIFEST = """\
rigrunner: replay/1
recordings:
  - {frequency: 0 Hz, load: 0 N, values: {angle: 0 deg, torque: 0.01 N·m}}
  - {frequency: 3.5 Hz, load: 300 N, file: swing.csv}
"""
