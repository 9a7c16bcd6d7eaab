"""The check on a plugin's factory, which comes before all checks on its product."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import MissingPackageError, PluginError
from rigrunner.api.hooks import Imported
from rigrunner.registry import call_problem, culprit, place_of
from rigrunner_testing.check import AnyCheck, Nonconformity, check
from rigrunner_testing.examination import useful_hint

if TYPE_CHECKING:
    from rigrunner_testing.subjects import Subject


@check(needs=(), fix="let the factory return the object for its settings, and raise nothing")
def can_be_made(subject: Subject) -> None:
    """Its factory makes something from its settings; for a device, with the required methods."""
    factory: Any = subject.any_record.factory  # type: ignore[attr-defined]  # every kind has one
    try:
        product = subject.make()
    except MissingPackageError:
        raise
    except PluginError as error:
        fix = useful_hint(error) or f"correct {_factory_name(factory)}"
        raise Nonconformity(error.message, fix=fix) from error
    except OSError as error:
        raise Nonconformity(
            f"making it raises {type(error).__name__}: {error} (in {culprit(error) or factory})",
            fix="open files, sockets and ports in `open` of a Driver, or in `connect`; the"
            " constructor keeps what it is given",
        ) from error

    problem = _call_problem(product, subject)
    if problem:
        raise Nonconformity(problem, fix=f"correct what {_factory_name(factory)} gives")


def _call_problem(product: Any, subject: Subject) -> str:
    """Return why the product cannot be called as required; '' if it can, or is a device."""
    what = getattr(product, "__name__", type(product).__name__)
    if subject.kind == "importer":
        read = getattr(product, "read", None)
        if not callable(read):
            return f"{what} has no method `read`"
        return call_problem(read, f"{what}.read", ("path", "columns", "group"))
    kinds = subject.registry.kinds
    arguments = next((kind.takes for kind in kinds if kind.name == subject.kind), ())
    if not arguments:
        return ""
    if not callable(product):
        return f"{what} cannot be called: it needs a method `__call__`"
    return call_problem(product, what, arguments)


def _factory_name(factory: Any) -> str:
    """Return the name of the factory, and where it is defined."""
    if isinstance(factory, Imported):
        return f"'{factory.place}'"
    name = getattr(factory, "__name__", type(factory).__name__)
    place = place_of(factory)
    if isinstance(factory, type):
        try:
            place = f"{inspect.getsourcefile(factory)}:{inspect.getsourcelines(factory)[1]}"
        except (OSError, TypeError):  # it has no source that Python could show
            place = ""
    return f"{name} ({place})" if place else name


CHECKS: tuple[AnyCheck, ...] = (can_be_made,)
