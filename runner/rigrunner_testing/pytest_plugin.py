"""The kit in pytest: each check on a plugin is a test of its own.

In pyproject.toml, so that the marker is known before a test module is:

    [tool.pytest.ini_options]
    addopts = ["-p", "rigrunner_testing.pytest_plugin"]

In a test module:

    @pytest.mark.conformance("device", "spring_scale", {"port": "/dev/ttyUSB0"})
    def test_it_conforms(conformance):
        conformance()

Without settings, those of the record's `trial` are taken. Where a server has to run first, define
the fixture `conformance_settings` in the module. The plugin is named, not found by an entry point:
installing Rigrunner makes no pytest slower.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import pytest

from rigrunner_testing.examination import conform
from rigrunner_testing.kinds import checks, subject

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from rigrunner_testing.check import AnyCheck

MARKER = "conformance"


def pytest_configure(config: pytest.Config) -> None:
    """Register the marker."""
    config.addinivalue_line(
        "markers",
        "conformance(kind, name, settings=None, drop_in=None): the plugin that `conformance`"
        " checks, with settings as in YAML",
    )


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Make a test of each check."""
    if "conformance" not in metafunc.fixturenames:
        return
    marker = metafunc.definition.get_closest_marker(MARKER)
    if marker is None:
        pytest.fail(
            "a test with the fixture 'conformance' needs a marker, such as"
            " @pytest.mark.conformance('device', 'spring_scale')",
            pytrace=False,
        )
    kind, *_ = _target(*marker.args, **marker.kwargs)
    metafunc.parametrize("conformance_check", checks(kind), ids=str)


@pytest.fixture
def conformance_settings(request: pytest.FixtureRequest) -> Mapping[str, Any] | None:
    """Return the settings of the marker; redefine it if they are known only in the test."""
    return _target_of(request)[2]


@pytest.fixture
def conformance(
    request: pytest.FixtureRequest,
    conformance_check: AnyCheck,
    conformance_settings: Mapping[str, Any] | None,
    tmp_path: Path,
) -> Callable[[], None]:
    """Return a function that runs the check: it fails, or skips if the check does not apply."""
    kind, name, _, drop_in = _target_of(request)
    plugin = subject(kind, name, conformance_settings, drop_in=drop_in, folder=tmp_path)
    return partial(_run_or_skip, partial(conform, plugin, conformance_check))


def _run_or_skip(work: Callable[[], str]) -> None:
    __tracebackhide__ = True
    why_not = work()
    if why_not:
        pytest.skip(why_not)


_Target = tuple[str, str, "Mapping[str, Any] | None", "Path | None"]


def _target_of(request: pytest.FixtureRequest) -> _Target:
    marker = request.node.get_closest_marker(MARKER)
    return _target(*marker.args, **marker.kwargs)


def _target(
    kind: str,
    name: str,
    settings: Mapping[str, Any] | None = None,
    drop_in: Path | None = None,
) -> _Target:
    return kind, name, settings, drop_in
