"""What a verification found: what held, what differs and where, and what it could not check."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from rigrunner.api.errors import ExitCode, RigrunnerError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable


@dataclass
class Verification:
    """A list of checks that grows as they are done."""

    held: list[str] = field(default_factory=list)
    differences: list[str] = field(default_factory=list)
    unchecked: list[str] = field(default_factory=list)
    """What could not be checked for want of a file: it decides nothing, and leaves all open."""
    information: list[str] = field(default_factory=list)
    """What decides nothing, but should be known: who signed, other versions."""

    @property
    def matches(self) -> bool:
        """Whether all was checked, and nothing differs."""
        return not (self.differences or self.unchecked)

    @property
    def exit_code(self) -> ExitCode:
        """How a command that did this ends."""
        if self.differences:
            return ExitCode.FAIL
        return ExitCode.UNDECIDED if self.unchecked else ExitCode.PASS

    def take(self, what: str, found: Iterable[object]) -> bool:
        """Keep the differences of one check, or that it held; return whether it did."""
        new = [f"{what}: {each}" for each in found]
        self.differences.extend(new)
        if not new:
            self.held.append(what)
        return not new

    def attempt(self, what: str, check: Callable[[], Iterable[object]]) -> bool:
        """Do one check; what keeps it from being done is a difference too."""
        try:
            found = list(check())
        except RigrunnerError as error:
            found = [error]
        return self.take(what, found)
