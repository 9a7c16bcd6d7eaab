"""As if the bearings were not installed: the core's tests pass without them.

    PYTHONPATH=tests python -m pytest -p without_bearings tests/unit

Nobody can import the package, and its entry points are not there. `.ci/run` runs `tests/unit`
so, but for the tests of the bearings and the places of `LEFT_OUT`.
"""

from __future__ import annotations

import sys
from importlib import metadata
from pathlib import Path

import pytest

BEARINGS = "rigrunner_bearings"
HERE = Path(__file__).parent
LEFT_OUT = {
    "its tests are those of the bearings": ("unit/rigrunner_bearings",),
    "it reads pages, examples and entry points of the whole project": (
        "unit/test_installed.py",
        "unit/test_made_pages.py",
        "unit/test_old_names.py",
        "unit/test_page_examples.py",
        "unit/rigrunner_panel/test_translations.py",
        "unit/rigrunner_testing/test_page.py",
        "unit/cli/test_completing.py::test_plugins_languages_shells_and_options_are_completed",
    ),
    "it measures with the swing tester": (
        "unit/analysis/test_analyse.py",
        "unit/analysis/test_decision.py",
        "unit/analysis/test_document.py",
        "unit/analysis/test_evidence.py",
        "unit/analysis/test_scrutiny.py",
        "unit/cli/test_attending.py::test_previously_tested_specimen_is_noted",
        "unit/cli/test_summary.py",
        "unit/documents/certifying",
        "unit/documents/test_decided_certificate.py",
        "unit/documents/verifying/test_run.py",
        "unit/rigrunner_fleet/archive/test_indexing.py::test_latest_decision_gives_the_verdict",
        "unit/rigrunner_fleet/archive/test_indexing.py::test_rows_equal_the_result_of_a_real_run",
        "unit/rigrunner_fleet/notebook/test_run.py::test_points_of_a_run_equal_its_result",
        "unit/rigrunner_fleet/notebook/test_run.py::test_analysing_again_gives_the_same_numbers",
        "unit/rigrunner_fleet/reanalysis/test_batch.py",
        "unit/rigrunner_fleet/reanalysis/test_command.py",
        "unit/rigrunner_panel/test_api.py",
        "unit/rigrunner_panel/test_interim.py",
        "unit/rigrunner_panel/test_manual.py",
        "unit/rigrunner_panel/test_preflight.py",
        "unit/rigrunner_panel/test_procedures.py",
        "unit/rigrunner_panel/test_studies.py::test_overlay_shows_results_with_their_uncertainty",
        "unit/rigrunner_panel/test_watched.py",
        "unit/rigrunner_plugins/devices/test_composite.py::test_stations_of_the_manual_are_valid",
        "unit/rigrunner_plugins/devices/test_fault.py",
        "unit/rigrunner_reports",
        "unit/rigrunner_testing/test_kinds_of_packages.py",
        "unit/rigrunner_testing/test_other_checks.py",
        "unit/rigrunner_testing/test_steps.py",
        "unit/run/test_calibration.py",
        "unit/run/test_decisions.py",
        "unit/run/test_long_run.py",
        "unit/run/test_planning.py",
        "unit/run/test_record.py",
        "unit/run/test_requirements.py",
        "unit/tools/by_hand",
        "unit/tools/comparing/test_compare.py",
        "unit/tools/importing/test_import.py",
        "unit/tools/schemas/test_files.py",
        "unit/tools/test_doctor.py",
        "unit/tools/test_labfolder.py",
        "unit/tools/test_new_plugin.py",
        "unit/tools/test_new_station.py",
    ),
}
"""What is not run without the bearings: folders, files, or the beginnings of the names of tests."""
_PLACES = tuple(place for places in LEFT_OUT.values() for place in places)


class _Missing:
    """Finds no module of the package, as the machine would without it."""

    @staticmethod
    def find_spec(name, path=None, target=None):  # noqa: ARG004  (Python's signature)
        if name.partition(".")[0] == BEARINGS:
            raise ModuleNotFoundError(f"No module named '{name}'", name=name)


assert BEARINGS not in sys.modules, "it was imported before this plugin of pytest"
_entry_points = metadata.entry_points


def entry_points(**selection):
    """Return all but those of the bearings, whoever found them: Dask adds a finder of its own."""
    found = _entry_points(**selection)
    return type(found)(point for point in found if point.name != BEARINGS)


metadata.entry_points = entry_points
sys.meta_path.insert(0, _Missing)


def pytest_configure():
    """Check that each file exists: a file that was moved would run again."""
    missing = [place for place in _PLACES if not (HERE / place.partition("::")[0]).exists()]
    assert not missing, f"without_bearings names files that do not exist: {', '.join(missing)}"


def pytest_ignore_collect(collection_path):
    """Leave out folders and files."""
    place = _place(collection_path)
    return True if place in _PLACES else None


@pytest.hookimpl(tryfirst=True)  # before thorough tests are left out
def pytest_collection_modifyitems(config, items):
    """Leave out single tests. Check that each exists: a renamed one would run again."""
    names = {item: f"{_place(item.path)}::{item.name}" for item in items}
    files = {_place(item.path) for item in items}
    for place in _PLACES:
        file, _, test = place.partition("::")
        found = not test or any(name.startswith(place) for name in names.values())
        assert found or file not in files, f"without_bearings names no test: {place}"
    left_out = [item for item, name in names.items() if name.startswith(_PLACES)]
    config.hook.pytest_deselected(items=left_out)
    items[:] = [item for item, name in names.items() if not name.startswith(_PLACES)]


def _place(path):
    return path.relative_to(HERE).as_posix() if path.is_relative_to(HERE) else ""
