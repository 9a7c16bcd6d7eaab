"""What holds of every module of the room: one kind each, and its events carry its keyword."""

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
def test_a_module_has_one_kind_and_its_actions_carry_its_keyword(name):
    module = MODULES[name]
    members = [
        each for each in vars(module).values() if getattr(each, "__module__", "") == module.__name__
    ]
    actions = [each for each in members if isinstance(each, type) and issubclass(each, Action)]
    assert {action.kind for action in actions} <= {module.STEP.name}
    assert all(is_dataclass(action) and action.__dataclass_params__.frozen for action in actions)
    assert module.STEP.settings in members
    assert f"`{module.STEP.name}`" in module.__doc__.splitlines()[0]


def test_the_hook_gives_the_kind_of_every_module_and_no_other():
    assert sorted(step.name for step in rigrunner_steps()) == sorted(
        module.STEP.name for module in MODULES.values()
    )
