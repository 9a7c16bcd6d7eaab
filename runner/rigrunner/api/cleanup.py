"""Cleanup that continues after errors: the first error is raised, later ones become its notes."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, TypeVar

from rigrunner.api.errors import RigrunnerError
from rigrunner.api.texts import visible

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterator, Sequence

_T = TypeVar("_T")


def do_all(*works: Callable[[], object]) -> None:
    """Call all in order, even after errors; then raise the first error, with the others noted.

    No exception, SystemExit and Ctrl-C included, skips a later call. If Ctrl-C was among the
    errors, it is the one raised.
    """
    raise_first(errors_of(*works))


def errors_of(*works: Callable[[], object]) -> list[BaseException]:
    """Call all in order, even after errors; return the exceptions."""
    errors: list[BaseException] = []
    for work in works:
        try:
            work()
        except BaseException as error:  # noqa: BLE001  (the next one has to have its turn)
            errors.append(error)
    return errors


def raise_first(errors: Sequence[BaseException]) -> None:
    """Raise the first error, or a Ctrl-C among them, with the others as its notes; or nothing."""
    if not errors:
        return
    first = next((error for error in errors if isinstance(error, KeyboardInterrupt)), errors[0])
    for error in errors:
        if error is not first:
            add_beside(first, error_text(error))
    raise first


@contextmanager
def noted_on(error: BaseException, what: str) -> Iterator[None]:
    """Let cleanup after an error add its own failure to that as a note; Ctrl-C is raised.

    So is what fails when a generator is closed: the notes of a GeneratorExit are not shown.

    ::

        try:
            ...
        except BaseException as error:
            with noted_on(error, "stopping the stream"):
                stop()
            raise
    """
    try:
        yield
    except KeyboardInterrupt:
        raise
    except BaseException as second:
        if isinstance(error, GeneratorExit):
            raise
        add_beside(error, f"{what} failed too: {error_text(second)}")


@contextmanager
def closed_after(blocks: Generator[_T], what: str) -> Iterator[Generator[_T]]:
    """Close a generator at the end; a failure is noted on the error that came before."""
    try:
        yield blocks
    except BaseException as error:
        with noted_on(error, what):
            blocks.close()
        raise
    blocks.close()


def add_beside(error: BaseException, text: str) -> None:
    """Add a note to an error, once."""
    if text not in getattr(error, "__notes__", ()):
        error.add_note(text)


def error_text(error: BaseException) -> str:
    """Return an error with its notes as one line; of a bug with the name of its type.

    Hidden characters, as a driver may quote them from its instrument, are made visible.
    """
    text = str(error) if isinstance(error, RigrunnerError) else f"{type(error).__name__}: {error}"
    return visible("; ".join((text, *getattr(error, "__notes__", ()))))
