"""Kinds of plugins that packages bring: checks on their plugins, and on the kinds themselves."""

from __future__ import annotations

import re
from importlib import import_module
from typing import TYPE_CHECKING, Protocol, cast

from rigrunner.api.hooks import KindRecord
from rigrunner_testing.check import AnyCheck, Check, Nonconformity, applies, check, demand
from rigrunner_testing.subjects import Subject

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.registry import Registry


class Conformance(Protocol):
    """A module with the checks of one kind."""

    CHECKS: Sequence[AnyCheck]
    SUBJECT: type[Subject]
    """The argument of the checks."""


def conformance(registry: Registry, kind: str) -> Conformance | None:
    """Return the module with the checks of a kind that a plugin brings, or None."""
    for record in registry.kinds:
        if record.name == kind and record.conformance:
            return cast("Conformance", import_module(record.conformance))
    return None


@check(needs=(), fix="call the hook 'rigrunner_' and a plural noun, and derive from PluginRecord")
def hook_is_named_as_hooks_are(subject: Subject) -> None:
    """The name of its hook begins with 'rigrunner_', so that a misspelt hook is detected."""
    hook = subject.record_as(KindRecord).hook
    demand(re.fullmatch(r"rigrunner_[a-z_]+s", hook), f"its hook is called '{hook}'")


@check(fix="let `conformance` name a module with CHECKS, of `rigrunner_testing.check`, and SUBJECT")
def brings_checks(subject: Subject) -> None:
    """It has checks for plugins of its kind, each with a remedy."""
    record = subject.record_as(KindRecord)
    applies(record.conformance, "its plugins have no checks of their own")
    try:
        module = cast("Conformance", import_module(record.conformance))
        checks, kind = tuple(module.CHECKS), module.SUBJECT
    except Exception as error:
        raise Nonconformity(f"'{record.conformance}': {type(error).__name__}: {error}") from error
    demand(checks, f"the CHECKS of '{record.conformance}' are empty")
    invalid = [entry for entry in checks if not isinstance(entry, Check) or not entry.fix]
    demand(not invalid, f"among its CHECKS are {invalid[:1]}, expected checks, each with its fix")
    demand(issubclass(kind, Subject), f"its SUBJECT is {kind!r}, which is not a Subject")


CHECKS: tuple[AnyCheck, ...] = (hook_is_named_as_hooks_are, brings_checks)
