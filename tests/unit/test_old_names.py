"""Names of 0.1.0 that plugins made then use, and what any package says of names that it took."""

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
TAKEN = {"rigrunner.signal.gone": "json.decoder", "rigrunner.api.Gone": "json.encoder:JSONEncoder"}


@pytest.fixture
def imported_anew():
    """Give a function that imports a module under a name that nothing has imported yet.

    Afterwards that name alone is forgotten: what it imported stays, since a second copy of
    its classes would be others than those that plugins hold.
    """
    asked = []

    def imported(name):
        asked.append(name)
        sys.modules.pop(name, None)
        return importlib.import_module(name)

    yield imported
    for name in asked:
        sys.modules.pop(name, None)


@pytest.mark.parametrize("old", MODULES)
def test_a_module_is_found_at_its_old_place_with_a_warning(old, imported_anew):
    with pytest.warns(DeprecationWarning, match=f"import {TABLE[old]} instead"):
        found = imported_anew(old)
    assert found is importlib.import_module(TABLE[old])
    with pytest.raises(AttributeError):
        _ = found.nothing_like_that


@pytest.mark.parametrize("old", NAMES)
def test_a_name_is_found_at_its_old_place_with_a_warning(old):
    (module, _, name), (new, _, new_name) = old.rpartition("."), TABLE[old].partition(":")
    with pytest.warns(DeprecationWarning, match=f"import {new_name} from {new}: ") as warned:
        exec(f"from {module} import {name}", found := {})  # noqa: S102
    assert found[name] is getattr(importlib.import_module(new), new_name)
    assert {each.filename for each in warned} == {"<string>"}, "whose import it is"


@pytest.mark.parametrize("module", sorted({old.rpartition(".")[0] for old in NAMES}))
def test_any_other_name_is_unknown(module):
    with pytest.raises(AttributeError, match="has no attribute 'CompensationRecords'"):
        _ = importlib.import_module(module).CompensationRecords
    with pytest.raises(ModuleNotFoundError):
        importlib.import_module(f"{module}.nothing_like_that")


def test_any_package_may_take_names_with_it(monkeypatch, imported_anew):
    points = [EntryPoint("stranger", f"{__name__}:TAKEN", moved.GROUP)]
    monkeypatch.setattr("importlib.metadata.entry_points", lambda **_: points)
    monkeypatch.setitem(sys.modules, __name__, sys.modules[__name__])
    moved.places.cache_clear()
    try:
        with pytest.warns(DeprecationWarning, match="import json.decoder instead"):
            assert imported_anew("rigrunner.signal.gone") is importlib.import_module("json.decoder")
        with pytest.warns(DeprecationWarning, match="import JSONEncoder from json.encoder"):
            exec("from rigrunner.api import Gone", {})  # noqa: S102
        with pytest.raises(AttributeError):
            _ = importlib.import_module("rigrunner.api").CompensationRecord
    finally:
        moved.places.cache_clear()
