"""The findings of a verification: what is OK, what differs and where, what was not checked."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from rigrunner.api.errors import ExitCode, RigrunnerError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator


@dataclass
class Verification:
    """A growing list of findings."""

    held: list[str] = field(default_factory=list)
    differences: list[str] = field(default_factory=list)
    withdrawn: list[str] = field(default_factory=list)
    """Who withdrew this document, when and why."""
    replaced: list[str] = field(default_factory=list)
    """The document that replaces this one."""
    unproven: list[str] = field(default_factory=list)
    """Pages that could not be regenerated and that no trusted key signed, and why."""
    not_recomputed: list[str] = field(default_factory=list)
    """Numbers by another revision of a method than the installed one."""
    unchecked: list[str] = field(default_factory=list)
    """What was not checked because a file is missing."""
    information: list[str] = field(default_factory=list)
    """Information that decides nothing, such as who signed, and other versions."""

    @property
    def matches(self) -> bool:
        """Whether all was checked, nothing differs, and the document is in force."""
        return self.exit_code is ExitCode.PASS

    @property
    def exit_code(self) -> ExitCode:
        """Exit code of the command, for the most serious finding."""
        return next((code for code, _ in self._verdicts()), ExitCode.PASS)

    @property
    def conclusion(self) -> str:
        """The conclusion in one line, the most serious finding first."""
        return "; ".join(text for _, text in self._verdicts()) or "MATCH"

    def _verdicts(self) -> Iterator[tuple[ExitCode, str]]:
        count = len(self.differences)
        if count:
            yield ExitCode.FAIL, f"DOES NOT MATCH: {count} difference{'' if count == 1 else 's'}"
        if self.withdrawn:
            yield ExitCode.WITHDRAWN, f"WITHDRAWN: {self.withdrawn[0]}"
        if self.replaced:
            yield ExitCode.REPLACED, f"REPLACED: {self.replaced[0]}"
        if self.unproven:
            yield ExitCode.UNPROVEN, f"PAGE NOT PROVEN: {_first(self.unproven)}"
        if self.not_recomputed:
            yield ExitCode.REVISED, f"NUMBERS NOT RECOMPUTED: {_first(self.not_recomputed)}"
        if self.unchecked:
            words = "not all could be checked"
            yield ExitCode.UNDECIDED, f"OPEN: {words if count else f'nothing differs, but {words}'}"

    def take(self, what: str, differences: Iterable[object]) -> bool:
        """Add the differences of one check, or that it is OK; return whether it is."""
        lines = [f"{what}: {difference}" for difference in differences]
        self.differences.extend(lines)
        if not lines:
            self.held.append(what)
        return not lines

    def attempt(self, what: str, check: Callable[[], Iterable[object]]) -> bool:
        """Do one check; an error that prevents it is a difference too."""
        try:
            differences = list(check())
        except RigrunnerError as error:
            differences = [error]
        return self.take(what, differences)


def _first(reasons: list[str]) -> str:
    more = len(reasons) - 1
    return f"{reasons[0]} (and {more} more)" if more else reasons[0]
