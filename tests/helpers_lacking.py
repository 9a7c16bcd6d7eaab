"""What tests need beyond Python: where it is missing they skip and say so; CI forbids them to."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, NoReturn

import pytest

from rigrunner.api.errors import MissingPackageError
from rigrunner.api.hooks import NoSettings
from rigrunner_reports.certificate.pdf import pdf_maker

if TYPE_CHECKING:
    from typing import Literal

    Part = Literal["BROWSER", "NGINX", "PDF", "POSTGRES", "YAML_SERVER"]


def lacking(part: Part, why: str) -> NoReturn:
    """Skip, or fail where the environment requires this part, by `RIGRUNNER_REQUIRE_...=1`."""
    if os.environ.get(f"RIGRUNNER_REQUIRE_{part}") == "1":
        pytest.fail(f"RIGRUNNER_REQUIRE_{part} is set, and {why}")
    pytest.skip(why)


def require_pdf() -> None:
    """Skip where WeasyPrint does not find what it needs of the system."""
    try:
        pdf_maker(NoSettings())
    except MissingPackageError as error:
        lacking("PDF", str(error))
