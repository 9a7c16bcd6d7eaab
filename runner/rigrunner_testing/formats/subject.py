"""A format under test: its output of each run, written once for all checks."""

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
    """The output of one run."""

    made: Any
    """Bytes, if it conforms."""
    touched: tuple[str, ...]
    """What it accessed meanwhile."""


@dataclass(frozen=True)
class FormatSubject(Subject):
    """A format of reports, of certificates, or of reports on many runs."""

    @property
    def inputs(self) -> tuple[Any, ...]:
        """ReportInputs, CertificateInputs or StudyInputs."""
        return _INPUTS[self.kind]()

    @property
    def writer(self) -> Callable[[Any], Any]:
        """The writer; NotApplicable if it needs a package that is not installed."""
        try:
            writer: Callable[[Any], Any] = self.made
        except MissingPackageError as error:
            raise NotApplicable(str(error)) from error
        return writer

    @cached_property
    def written(self) -> tuple[Written, ...]:
        """Its output for each input."""
        self.writer(self.inputs[0])  # what is loaded once is loaded now, and not watched
        written = []
        for given in self.inputs:
            with watched() as touched:
                made = self.writer(given)
            written.append(Written(made, tuple(touched)))
        return tuple(written)
