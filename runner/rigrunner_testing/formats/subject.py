"""A format under check: what it writes of each run, written once for the checks that read it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import MissingPackageError
from rigrunner_testing.check import NotApplicable
from rigrunner_testing.device.watching import watched
from rigrunner_testing.formats.inputs import certificate_inputs, report_inputs
from rigrunner_testing.formats.studies import study_inputs
from rigrunner_testing.subjects import Subject

if TYPE_CHECKING:
    from collections.abc import Callable


_INPUTS: dict[str, Callable[[], tuple[Any, ...]]] = {
    "report_format": report_inputs,
    "certificate_format": certificate_inputs,
    "study_format": study_inputs,
}


@dataclass(frozen=True)
class Written:
    """What came of writing one run."""

    made: Any
    """Bytes, if it conforms."""
    touched: tuple[str, ...]
    """By what it reached beyond the program meanwhile."""


@dataclass(frozen=True)
class FormatSubject(Subject):
    """A format of reports, of certificates, or of reports on many runs."""

    @property
    def inputs(self) -> tuple[Any, ...]:
        """What it is given: ReportInputs, CertificateInputs or StudyInputs."""
        return _INPUTS[self.kind]()

    @property
    def writer(self) -> Callable[[Any], Any]:
        """What the factory makes; NotApplicable where it needs a package that is not there."""
        try:
            writer: Callable[[Any], Any] = self.made
        except MissingPackageError as error:
            raise NotApplicable(str(error)) from error
        return writer

    @cached_property
    def written(self) -> tuple[Written, ...]:
        """What it makes of each input."""
        self.writer(self.inputs[0])  # what is loaded once is loaded now, and not watched
        return tuple(self._write(given) for given in self.inputs)

    def _write(self, given: Any) -> Written:
        with watched() as touched:
            made = self.writer(given)
        return Written(made, tuple(touched))
