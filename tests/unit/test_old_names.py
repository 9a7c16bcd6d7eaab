"""Names of 0.1.0 that old plugins use, and names that any package may declare as moved."""

from __future__ import annotations

import importlib
import sys
from importlib.metadata import EntryPoint

import pytest

import rigrunner_bearings.api
import rigrunner_bearings.moved
import rigrunner_testing
import rigrunner_testing.moved
from rigrunner import moved

TABLE = rigrunner_bearings.moved.MOVED | rigrunner_testing.moved.MOVED
PROPERTIES = {
    "rigrunner.api.data.RunData.rig",
    "rigrunner.api.results.Result.compensations",
    "rigrunner.api.verdict.LimitDecision.load_n",
}
NAMES = sorted(old for old, new in TABLE.items() if ":" in new and old not in PROPERTIES)
MODULES = sorted(set(TABLE) - set(NAMES) - PROPERTIES - {"rigrunner.testing.pytest_plugin"})
MOVED_NAMES = {
    "rigrunner.signal.gone": "json.decoder",
    "rigrunner.api.Gone": "json.encoder:JSONEncoder",
}


@pytest.fixture
def fresh_import():
    """Return a function that imports a module under a name that nothing has imported yet.

    Afterwards only that name is removed: what it imported stays, since a second copy of
    its classes would differ from those that plugins hold.
    """
    names = []

    def imported(name):
        names.append(name)
        sys.modules.pop(name, None)
        return importlib.import_module(name)

    yield imported
    for name in names:
        sys.modules.pop(name, None)


@pytest.mark.parametrize("old", MODULES)
def test_old_module_is_imported_with_a_warning(old, fresh_import):
    with pytest.warns(DeprecationWarning, match=f"import {TABLE[old]} instead"):
        module = fresh_import(old)
    assert module is importlib.import_module(TABLE[old])
    with pytest.raises(AttributeError):
        _ = module.nothing_like_that


@pytest.mark.parametrize("old", NAMES)
def test_old_name_is_imported_with_a_warning(old):
    (module, _, name), (new, _, new_name) = old.rpartition("."), TABLE[old].partition(":")
    with pytest.warns(DeprecationWarning, match=f"import {new_name} from {new}: ") as warned:
        exec(f"from {module} import {name}", namespace := {})  # noqa: S102
    assert namespace[name] is getattr(importlib.import_module(new), new_name)
    assert {warning.filename for warning in warned} == {"<string>"}, "whose import it is"


@pytest.mark.parametrize("module", sorted({old.rpartition(".")[0] for old in NAMES}))
def test_unknown_names_raise(module):
    with pytest.raises(AttributeError, match="has no attribute 'CompensationRecords'"):
        _ = importlib.import_module(module).CompensationRecords
    with pytest.raises(ModuleNotFoundError):
        importlib.import_module(f"{module}.nothing_like_that")


def test_any_package_may_declare_moved_names(monkeypatch, fresh_import):
    points = [EntryPoint("stranger", f"{__name__}:MOVED_NAMES", moved.GROUP)]
    monkeypatch.setattr("importlib.metadata.entry_points", lambda **_: points)
    monkeypatch.setitem(sys.modules, __name__, sys.modules[__name__])
    moved.places.cache_clear()
    try:
        with pytest.warns(DeprecationWarning, match="import json.decoder instead"):
            assert fresh_import("rigrunner.signal.gone") is importlib.import_module("json.decoder")
        with pytest.warns(DeprecationWarning, match="import JSONEncoder from json.encoder"):
            exec("from rigrunner.api import Gone", {})  # noqa: S102
        with pytest.raises(AttributeError):
            _ = importlib.import_module("rigrunner.api").CompensationRecord
    finally:
        moved.places.cache_clear()
