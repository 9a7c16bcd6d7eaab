"""A format under test: its output of each run, written once for all checks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import MissingPackageError
from rigrunner_testing.check import NotApplicable
from rigrunner_testing.device.watching import watch_accesses
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

    content: Any
    """Bytes, if it conforms."""
    accesses: tuple[str, ...]
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
        self.writer(self.inputs[0])  # so that accesses of lazy imports do not count
        written = []
        for run_input in self.inputs:
            with watch_accesses() as accesses:
                content = self.writer(run_input)
            written.append(Written(content, tuple(accesses)))
        return tuple(written)
