"""Providers of plugins are found by the entry points of installed distributions."""

from __future__ import annotations

import importlib
import sys

import pytest

from rigrunner.registry import culprit
from rigrunner.registry.installed import Installed, installed


@pytest.fixture
def lab(tmp_path, monkeypatch):
    """An environment with one provider."""
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    add(tmp_path, "ours", "1.0", "[rigrunner]\nours = ours.hooks\n")
    add(tmp_path, "other", "3.1", "[console_scripts]\nother = other:main\n")
    return tmp_path


def add(site, name, version, entry_points):
    folder = site / f"{name}-{version}.dist-info"
    folder.mkdir(parents=True)
    text = f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n"
    (folder / "METADATA").write_text(text)
    (folder / "entry_points.txt").write_text(entry_points)
    importlib.invalidate_caches()


OURS = Installed("ours", "ours.hooks", "1.0", "ours")


def test_added_provider_is_found_with_name_and_version(lab):
    assert installed() == (OURS,)
    add(lab, "beside", "0.2", "[rigrunner]\nbeside = beside:hooks\n")
    assert installed() == (Installed("beside", "beside:hooks", "0.2", "beside"), OURS)


@pytest.mark.parametrize(("distribution", "name"), [("beside", "beside 0.2, "), ("rigrunner", "")])
def test_culprit_is_plugin_of_another_distribution(lab, distribution, name):
    add(lab, distribution, "0.2", "[rigrunner]\nbeside = beside.hooks\n")
    (lab / "beside.py").write_text("def broken():\n    raise ValueError('worn')\n")
    sys.modules.pop("beside", None)
    with pytest.raises(ValueError, match="worn") as caught:
        importlib.import_module("beside").broken()
    assert culprit(caught.value) == (f"{name}{lab / 'beside.py'}:2" if name else "")


def test_shipped_providers_are_installed():
    assert {"rigrunner_bearings", "rigrunner_plugins", "rigrunner_reports"} <= {
        provider.name for provider in installed()
    }
