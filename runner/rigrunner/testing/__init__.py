"""The conformance kit: what every plugin must keep to, as checks that a test can call.

For a package's own tests there is a pytest plugin, `rigrunner.testing.pytest_plugin`; on the
command line it is `rigrunner check-plugin NAME`.
"""

from rigrunner.testing.check import (
    AnyCheck,
    Check,
    Finding,
    Nonconformity,
    NotApplicable,
    State,
)
from rigrunner.testing.examine import conform, examine, examine_one
from rigrunner.testing.kinds import checks, subject
from rigrunner.testing.replayed import replayed
from rigrunner.testing.subject import Subject

__all__ = [
    "AnyCheck",
    "Check",
    "Finding",
    "Nonconformity",
    "NotApplicable",
    "State",
    "Subject",
    "checks",
    "conform",
    "examine",
    "examine_one",
    "replayed",
    "subject",
]
