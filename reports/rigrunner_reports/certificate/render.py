"""Render a certificate with a letterhead as one self-contained HTML page."""

from __future__ import annotations

from base64 import b64encode
from functools import lru_cache
from importlib.resources import files
from typing import TYPE_CHECKING

from jinja2 import (
    ChoiceLoader,
    DictLoader,
    PackageLoader,
    StrictUndefined,
    TemplateError,
    TemplateSyntaxError,
)
from jinja2.sandbox import SandboxedEnvironment
from markupsafe import Markup

from rigrunner.api import Location
from rigrunner.api.certificate import certificate_json
from rigrunner.api.errors import InvalidFileError, Problem
from rigrunner.plots import draw
from rigrunner_reports.certificate.figure import named_figures, over_frequency
from rigrunner_reports.certificate.texts import texts
from rigrunner_reports.certificate.wording import Wording
from rigrunner_reports.render import css_string

if TYPE_CHECKING:
    from rigrunner.api import CertificateInput
    from rigrunner.api.figures import Picture
    from rigrunner.api.letterhead import Letterhead
    from rigrunner.plots import Plot

PACKAGE = "rigrunner_reports"
TEMPLATES = "certificate/templates"
TEMPLATE = "certificate.html.j2"
_OF_STYLE = str.maketrans({"<": "\\3c "})
"""Characters that must not be in a <style> element, as CSS escapes."""


def html(certificate_input: CertificateInput) -> bytes:
    """Return the certificate as UTF-8, with its JSON; the same input gives the same bytes.

    Raises InvalidFileError for wrong texts or templates of the letterhead.
    """
    certificate, letterhead = certificate_input.certificate, certificate_input.letterhead
    wording = Wording(texts(certificate.appearance.language, letterhead.texts))
    style = files(PACKAGE).joinpath(TEMPLATES, "certificate.css").read_text(encoding="utf-8")
    picture, logo = over_frequency(certificate, wording), None
    if letterhead.logo is not None:
        content = b64encode(letterhead.logo.content).decode("ascii")
        uri = f"data:{letterhead.logo.media_type};base64,{content}"
        logo = {"uri": uri, "text": letterhead.logo.text}
    try:
        text = (
            _environment(tuple(sorted(letterhead.templates.items())))
            .get_template(TEMPLATE)
            .render(
                c=certificate,
                t=wording.texts,
                w=wording,
                plot=None if picture is None else _draw(picture),
                named_plots={
                    name: _draw(figure)
                    for name, figure in named_figures(certificate, wording).items()
                },
                logo=logo,
                style=Markup(style + letterhead.style.translate(_OF_STYLE)),  # noqa: S704  (escaped)
                css_string=css_string,
                page=page_counter(wording),
                data=Markup(certificate_json(certificate)),  # noqa: S704  (escapes <, > and &)
            )
        )
    except (TemplateError, TypeError, KeyError, ValueError, AttributeError) as error:
        if not letterhead.templates:
            raise
        raise InvalidFileError([_problem(error, letterhead)]) from error
    return text.encode("utf-8")


def page_counter(wording: Wording) -> Markup:
    """Return 'page x of y' in a language, as the content of a CSS margin box."""
    marks = {"page": "\0p\0", "pages": "\0q\0"}
    counters = {"p": Markup("counter(page)"), "q": Markup("counter(pages)")}
    parts = wording.texts("page", **marks).split("\0")
    return Markup(" ").join(counters.get(part) or css_string(part) for part in parts if part)


@lru_cache(maxsize=8)
def _draw(picture: Picture) -> Plot:
    """Return the drawing of a figure: the same in each form of a certificate, and on trial."""
    return draw(picture)


@lru_cache(maxsize=2)  # a certificate is made in two forms, twice each: compiling takes longest
def _environment(own: tuple[tuple[str, str], ...]) -> SandboxedEnvironment:
    """Return the template environment. A laboratory's own templates come first, in a sandbox."""
    return SandboxedEnvironment(
        loader=ChoiceLoader([DictLoader(dict(own)), PackageLoader(PACKAGE, TEMPLATES)]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


def _problem(error: Exception, letterhead: Letterhead) -> Problem:
    """Return where in the laboratory's own templates an error occurred."""
    name = line = None
    if isinstance(error, TemplateSyntaxError):
        name, line = error.name, error.lineno
    trace = error.__traceback__
    while trace is not None and not isinstance(error, TemplateSyntaxError):
        file = trace.tb_frame.f_code.co_filename
        if file in letterhead.templates or file == "<template>":
            name, line = trace.tb_frame.f_globals.get("__name__", file), trace.tb_lineno
        trace = trace.tb_next
    where = Location(f"templates/{name}" if name in letterhead.templates else "templates", line)
    hint = "the shipped template of that name shows what there is"
    return Problem(f"{type(error).__name__}: {error}", where, hint=hint)
