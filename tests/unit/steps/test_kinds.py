"""Every module of the package has one kind of step, and its events carry its keyword."""

from __future__ import annotations

from dataclasses import is_dataclass
from importlib import import_module
from pkgutil import iter_modules

import pytest

from rigrunner import steps
from rigrunner.api.steps import Action
from rigrunner.steps.hooks import rigrunner_steps

NAMES = sorted(module.name for module in iter_modules(steps.__path__) if module.name != "hooks")
MODULES = {name: import_module(f"{steps.__name__}.{name}") for name in NAMES}


@pytest.mark.parametrize("name", NAMES)
def test_each_module_has_one_kind_with_its_keyword(name):
    module = MODULES[name]
    members = [
        member
        for member in vars(module).values()
        if getattr(member, "__module__", "") == module.__name__
    ]
    actions = [
        member for member in members if isinstance(member, type) and issubclass(member, Action)
    ]
    assert {action.kind for action in actions} <= {module.STEP.name}
    assert all(is_dataclass(action) and action.__dataclass_params__.frozen for action in actions)
    assert module.STEP.settings in members
    assert f"`{module.STEP.name}`" in module.__doc__.splitlines()[0]


def test_hook_returns_the_kinds_of_all_modules():
    assert sorted(step.name for step in rigrunner_steps()) == sorted(
        module.STEP.name for module in MODULES.values()
    )
