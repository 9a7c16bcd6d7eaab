"""Render a certificate as a tagged PDF with bookmarks, page numbers and the data attached."""

from __future__ import annotations

import hashlib
import io
from contextlib import redirect_stdout
from datetime import datetime
from typing import TYPE_CHECKING

from rigrunner.api import MissingPackageError
from rigrunner.api.certificate import certificate_json
from rigrunner_reports.certificate.render import html

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api import CertificateInput, NoSettings

VARIANT = "pdf/ua-1"
"""Tagged, with title and language, as PDF/UA requires; validators may still report errors."""
MATHEMATICS = """
math { display: block; text-align: center; font-family: "DejaVu Serif", serif; }
mi { font-style: italic; } mo { margin: 0 0.15em; }
mfrac { display: inline-block; vertical-align: middle; text-align: center; }
mfrac > * { display: block; padding: 0 0.2em; }
mfrac > :first-child { border-bottom: 0.05em solid; }
msup > :last-child { font-size: 70%; vertical-align: super; }
msub > :last-child { font-size: 70%; vertical-align: sub; }
msqrt::before { content: "√("; } msqrt::after { content: ")"; }
"""
"""The style of MathML, which WeasyPrint does not know."""
MISSING = "WeasyPrint is not installed"
HINT = "pip install 'rigrunner[pdf]', or print the HTML from a browser"


def pdf_maker(_: NoSettings) -> Callable[[CertificateInput], bytes]:
    """Return the function that makes a PDF; raise MissingPackageError without WeasyPrint."""
    try:
        with redirect_stdout(io.StringIO()):  # where Pango is missing it prints what we say below
            import weasyprint  # noqa: F401, PLC0415  (optional, and a second to load)
    except ImportError as error:
        raise MissingPackageError(MISSING, hint=HINT) from error
    except OSError as error:
        raise MissingPackageError(
            f"WeasyPrint does not find the library Pango: {error}",
            hint="on Debian: apt install libpango-1.0-0 libpangoft2-1.0-0 libharfbuzz-subset0",
        ) from error
    return pdf


def pdf(certificate_input: CertificateInput) -> bytes:
    """Return the certificate as PDF; nothing is fetched."""
    from weasyprint import CSS, HTML, Attachment  # noqa: PLC0415  (see `pdf_maker`)
    from weasyprint.urls import URLFetcher  # noqa: PLC0415  (see `pdf_maker`)

    certificate = certificate_input.certificate
    data = certificate_json(certificate)
    issued = datetime.fromisoformat(certificate.issued_utc)
    attachment = Attachment(
        string=data,
        name=f"{certificate.number}.json",
        description=f"{certificate.number} (JSON)",
        created=issued,
        modified=issued,
        relationship="Source",
    )
    offline = URLFetcher(allowed_protocols=("data",), allow_redirects=False)
    document = HTML(string=html(certificate_input).decode("utf-8"), url_fetcher=offline)
    content = document.write_pdf(
        attachments=[attachment],
        stylesheets=[CSS(string=MATHEMATICS)],
        pdf_identifier=hashlib.sha256(data.encode()).digest()[:16],
        pdf_variant=VARIANT,
    )
    assert isinstance(content, bytes)  # noqa: S101  (without a target it is bytes)
    return content
