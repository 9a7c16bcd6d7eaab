"""Checks on the output of a format: bytes, reproducible and harmless."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from rigrunner.api.hooks import CertificateFormatRecord, ReportFormatRecord, StudyFormatRecord
from rigrunner_testing.check import AnyCheck, applies, check, demand
from rigrunner_testing.device.watching import census, leaks_since
from rigrunner_testing.formats.inputs import TAG

if TYPE_CHECKING:
    from rigrunner_testing.formats.subject import FormatSubject

SUFFIX = re.compile(r"\.[a-z0-9]+(\.[a-z0-9]+)*")
FETCHED = re.compile(
    r"<(?:script|img|link|iframe|source|video|audio|object|embed|use|image)\b[^>]*?"
    r"(?:src|href|data|srcset)\s*=\s*[\"']?\s*(?:https?:)?//[^\s\"'>]*"
    r"|url\(\s*[\"']?\s*(?:https?:)?//[^)]*|@import\s[^;]*",
    re.IGNORECASE,
)
"""What a browser would fetch as soon as the page is shown."""


@check(fix="return `bytes`, not `str`; give the record a suffix such as '.html'")
def makes_a_file(subject: FormatSubject) -> None:
    """It makes a file with a suffix of every run, with and without a verdict."""
    record = subject.any_record
    kinds = (ReportFormatRecord, CertificateFormatRecord, StudyFormatRecord)
    assert isinstance(record, kinds)  # noqa: S101  (the kind says so)
    demand(SUFFIX.fullmatch(record.suffix), f"the suffix is '{record.suffix}'")
    for file in subject.written:
        content = file.content
        demand(isinstance(content, bytes), f"it makes {type(content).__name__}, not bytes")
        demand(content, "it makes no byte")


@check(
    fix="write no date of today, no random names, and nothing in the order of a set",
    needs=("makes_a_file",),
)
def same_run_same_bytes(subject: FormatSubject) -> None:
    """The same run gives the same bytes, so that documents can be made again and compared."""
    for run_input, file in zip(subject.inputs, subject.written, strict=True):
        demand(subject.writer(run_input) == file.content, "it writes different bytes each time")


@check(
    fix="escape what was typed: jinja2 with autoescape=True, or html.escape",
    needs=("makes_a_file",),
)
def names_are_escaped(subject: FormatSubject) -> None:
    """In a format with markup, a name that is a script is shown as text, not run."""
    for file in subject.written:
        applies(_is_markup(file.content), "what it makes is not markup")
        text = file.content.decode("utf-8")
        start = text.find(TAG)
        before = text[start - 40 : start]
        demand(start < 0, f"a specimen named {TAG} is in it unescaped: ...{before}...")
        demand("<img src=x" not in text, "a specimen's name opens a tag of its own")


@check(fix="put styles, fonts and pictures into the file itself", needs=("makes_a_file",))
def nothing_is_fetched(subject: FormatSubject) -> None:
    """Neither making nor showing it accesses another computer."""
    for file in subject.written:
        demand(not file.accesses, f"making it did: {', '.join(file.accesses)}")
        if _is_markup(file.content):
            match = FETCHED.search(file.content.decode("utf-8"))
            demand(match is None, f"showing it would load {match and match[0][:120]}")


@check(fix="close what is opened; end threads", needs=("makes_a_file",))
def leaves_nothing_open(subject: FormatSubject) -> None:
    """It leaves no thread and no open file."""
    subject.writer(subject.inputs[0])  # so that lazy imports, in each thread, do not count
    before = census()
    subject.writer(subject.inputs[0])
    leaks = leaks_since(before)
    demand(not leaks, f"it left behind: {leaks}")


def _is_markup(content: bytes) -> bool:
    return content.lstrip()[:1] == b"<"


CHECKS: tuple[AnyCheck, ...] = (
    makes_a_file,
    same_run_same_bytes,
    names_are_escaped,
    nothing_is_fetched,
    leaves_nothing_open,
)
