"""Every shipped plugin passes the conformance kit; each check is a separate test."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from helpers_lacking import require_pdf
from rigrunner.api.errors import PluginError
from rigrunner.registry import load_registry
from rigrunner_testing import checks, subject
from unit.rigrunner_plugins.devices.helpers_conformance import (
    NOT_APPLICABLE,
    SCANS,
    applicable,
    assert_it_conforms,
    assert_not_applicable,
)

pytestmark = pytest.mark.figures

REGISTRY = load_registry()


def _can_be_tried(plugin):
    try:
        REGISTRY.validated(plugin.kind, plugin.record.name, plugin.record.trial)
    except PluginError:
        return False
    return True


TRIED = [(plugin.kind, plugin.record.name) for plugin in REGISTRY.plugins if _can_be_tried(plugin)]
CASES = [(kind, name, check) for kind, name in TRIED for check in applicable(kind, name)]
NOT_ALONE = [
    (plugin.kind, plugin.record.name) for plugin in REGISTRY.plugins if not _can_be_tried(plugin)
]
"""These need files or an instrument; separate tests run the kit on them."""


@lru_cache(maxsize=2)
def cached_subject(kind, name, folder):
    """Return the plugin, cached: most checks of a compensation need a second of preparation."""
    return subject(kind, name, registry=REGISTRY, folder=folder)


LONG = {"truth_is_within_its_interval", "truth_is_within_it_on_another_rig"}
LIKE_ANOTHER = {("compensation", "model_inverse")}
"""It takes as long as template_inverse, and differs only in how it finds the bearing."""
SAME_RULE = "guard_band_fraction"
"""The class of guard_band_u, with another factor."""
REPEATED = {
    ("analysis", "curve", "covers_the_truth"),
    ("analysis", "equation", "covers_the_truth"),
    ("certificate_format", "pdf", "leaves_nothing_open"),
    ("study_format", "html", "leaves_nothing_open"),
}
"""These make many runs or documents; tests of these plugins cover the same."""


def case(kind, name, check):
    """Return a case as a parameter; slow ones are marked thorough."""
    is_long = (
        (kind, name) in LIKE_ANOTHER
        or check.name in LONG
        or (name == SAME_RULE and check.name in SCANS)
        or (kind, name, check.name) in REPEATED
    )
    marks = [pytest.mark.thorough] * is_long
    return pytest.param(kind, name, check, id=f"{kind}-{name}-{check}", marks=marks)


@pytest.mark.parametrize(("kind", "name", "check"), [case(*args) for args in CASES])
def test_plugin_passes_check(kind, name, check, tmp_path):
    if name == "pdf":
        require_pdf()
    assert_it_conforms(cached_subject(kind, name, tmp_path if kind == "device" else None), check)


@pytest.mark.parametrize(("kind", "name"), [plugin for plugin in TRIED if plugin in NOT_APPLICABLE])
def test_inapplicable_checks_state_a_reason(kind, name, tmp_path):
    assert_not_applicable(cached_subject(kind, name, tmp_path if kind == "device" else None))


def test_inapplicable_checks_exist():
    plugins = {(plugin.kind, plugin.record.name) for plugin in REGISTRY.plugins}
    assert set(NOT_APPLICABLE) <= plugins
    for (kind, name), listed in NOT_APPLICABLE.items():
        assert listed <= {check.name for check in checks(kind)}, (kind, name)


@pytest.mark.parametrize(("kind", "name"), NOT_ALONE)
def test_plugin_without_trial_settings_asks_for_them(kind, name):
    with pytest.raises(PluginError, match="give settings with which it can be tried"):
        subject(kind, name, registry=REGISTRY)


def test_most_plugins_have_trial_settings():
    assert len(NOT_ALONE) <= len(REGISTRY.plugins) / 3
    assert {kind for kind, _ in NOT_ALONE} <= {"device", "event_sink"}


class TestReplay:
    """The device `replay`, with files written here."""

    @pytest.fixture(scope="class")
    @classmethod
    def files(cls, tmp_path_factory):
        folder = tmp_path_factory.mktemp("files")
        angle = np.sin(np.arange(40_000) / 50)
        rows = np.c_[angle, 2 * angle]
        np.savetxt(folder / "swing.csv", rows, delimiter=",", header="a,t", comments="")
        folder.joinpath("manifest.yaml").write_text(MANIFEST)
        return folder

    @pytest.fixture
    def replay(self, files, tmp_path):
        columns = {
            "angle": {"column": "a", "unit": "deg"},
            "torque": {"column": "t", "unit": "N·m"},
        }
        settings = {"folder": str(files), "rate": "10 kHz", "channels": columns}
        return subject("device", "replay", settings, registry=REGISTRY, folder=tmp_path)

    @pytest.mark.parametrize("check", applicable("device", "replay"), ids=str)
    def test_plugin_passes_check(self, replay, check):
        assert_it_conforms(replay, check)

    def test_inapplicable_checks_state_a_reason(self, replay):
        assert_not_applicable(replay)


MANIFEST = """\
rigrunner: replay/1
recordings:
  - {frequency: 0 Hz, load: 0 N, values: {angle: 0 deg, torque: 0.01 N·m}}
  - {frequency: 3.5 Hz, load: 300 N, file: swing.csv}
"""
