"""What tests of several packages share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import pytest

from helpers_cli import Called, call

if TYPE_CHECKING:
    from pathlib import Path

pytest_plugins = ["rigrunner.testing.pytest_plugin"]


@dataclass(frozen=True)
class Demo:
    """The demonstration, run once: its folder, its two runs, and what it printed."""

    folder: Path
    no_load: Path
    loaded: Path
    called: Called


@pytest.fixture(scope="session")
def demo(tmp_path_factory) -> Demo:
    """Run `rigrunner demo`, once per session; treat its folder as read-only."""
    folder = tmp_path_factory.mktemp("demo") / "runs"
    called = call("demo", "--dir", folder)
    assert called.code == 0, called.err
    no_load, loaded = sorted(folder.iterdir())
    return Demo(folder, no_load, loaded, called)
