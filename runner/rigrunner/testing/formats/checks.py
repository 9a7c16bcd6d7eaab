"""Checks on what a format makes of a run: bytes, the same each time, that harm nobody."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import MissingPackageError
from rigrunner.api.hooks import CertificateFormatRecord, ReportFormatRecord
from rigrunner.testing.check import AnyCheck, NotApplicable, applies, check, demand
from rigrunner.testing.device.watching import census, watched
from rigrunner.testing.formats.inputs import TAG, certificate_inputs, report_inputs

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.testing.subject import Subject

SUFFIX = re.compile(r"\.[a-z0-9]+(\.[a-z0-9]+)*")
FETCHED = re.compile(
    r"<(?:script|img|link|iframe|source|video|audio|object|embed|use|image)\b[^>]*?"
    r"(?:src|href|data|srcset)\s*=\s*[\"']?\s*(?:https?:)?//[^\s\"'>]*"
    r"|url\(\s*[\"']?\s*(?:https?:)?//[^)]*|@import\s[^;]*",
    re.IGNORECASE,
)
"""What a browser would load from elsewhere as soon as the page is shown."""


@check(mend="return `bytes`, not `str`; give the record a suffix such as '.html'")
def makes_a_file(subject: Subject) -> None:
    """It makes bytes of every run, one with a verdict and one without, for a file with a suffix."""
    record = subject.any_record
    assert isinstance(record, (ReportFormatRecord, CertificateFormatRecord))  # noqa: S101  (the kind)
    demand(SUFFIX.fullmatch(record.suffix), f"the suffix is '{record.suffix}'")
    for given in _inputs(subject):
        made = _writer(subject)(given)
        demand(isinstance(made, bytes), f"it makes {type(made).__name__}, not bytes")
        demand(made, "it makes no byte")


@check(mend="write no date of today, no random names, and nothing in the order of a set")
def same_run_same_bytes(subject: Subject) -> None:
    """The same run gives the same bytes: what is printed can be made again and compared."""
    for given in _inputs(subject):
        demand(_writer(subject)(given) == _writer(subject)(given), "it makes other bytes each time")


@check(mend="escape what was typed: jinja2 with autoescape=True, or html.escape")
def names_are_escaped(subject: Subject) -> None:
    """A name that is a script is shown as text, not run, where the format is one of markup."""
    for given in _inputs(subject):
        text = _markup(_writer(subject)(given))
        at = text.find(TAG)
        demand(at < 0, f"a specimen named {TAG} stands in it as it is: ...{text[at - 40 : at]}...")
        demand("<img src=x" not in text, "a specimen's name opens a tag of its own")


@check(mend="put styles, fonts and pictures into the file itself")
def nothing_is_fetched(subject: Subject) -> None:
    """Neither making it nor showing it asks another computer for anything."""
    for given in _inputs(subject):
        write = _writer(subject)
        with watched() as touched:
            made = write(given)
        demand(not touched, f"making it did: {', '.join(touched)}")
        if _is_markup(made):
            found = FETCHED.search(made.decode("utf-8"))
            demand(found is None, f"showing it would load {found and found[0][:120]}")


@check(mend="close what is opened; end threads")
def leaves_nothing_open(subject: Subject) -> None:
    """It leaves no thread and no open file behind."""
    given = _inputs(subject)[0]
    _writer(subject)(given)  # what is loaded once is loaded now
    before = census()
    _writer(subject)(given)
    more = census().more_than(before)
    demand(not more, f"it left behind: {more}")


def _inputs(subject: Subject) -> tuple[Any, ...]:
    return report_inputs() if subject.kind == "report_format" else certificate_inputs()


def _writer(subject: Subject) -> Callable[[Any], Any]:
    try:
        writer: Callable[[Any], Any] = subject.made
    except MissingPackageError as error:
        raise NotApplicable(str(error)) from error
    return writer


def _is_markup(made: bytes) -> bool:
    return made.lstrip()[:1] == b"<"


def _markup(made: bytes) -> str:
    applies(_is_markup(made), "what it makes is no markup")
    return made.decode("utf-8")


CHECKS: tuple[AnyCheck, ...] = (
    makes_a_file,
    same_run_same_bytes,
    names_are_escaped,
    nothing_is_fetched,
    leaves_nothing_open,
)
