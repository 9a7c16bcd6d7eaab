"""How Sphinx makes a site of these pages: `sphinx-build -n -W docs FOLDER`.

Nothing is loaded from elsewhere when the site is read, so equations are MathML, which browsers draw
themselves.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

import rigrunner

if TYPE_CHECKING:
    from sphinx.application import Sphinx
    from sphinx.writers.html5 import HTML5Translator

project = "Rigrunner"
author = "The Rigrunner maintainers"
version = release = rigrunner.__version__

extensions = ["myst_parser"]
myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 4
exclude_patterns = ["decisions", "evidence", "dependencies.md"]
"""They explain and prove, for those who have the sources."""

# `sphinx-build -b linkcheck docs FOLDER` asks the network for what is linked beyond this site
linkcheck_timeout = 20
linkcheck_retries = 2
linkcheck_ignore = [r"http://(127\.0\.0\.1|localhost)"]
linkcheck_allowed_redirects = {r"https://doi\.org/.*": r"https://.*"}

html_theme = "furo"
html_title = f"Rigrunner {version}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_copyright = False
html_math_renderer = "mathml"


def in_a_line(writer: HTML5Translator, node: nodes.math) -> None:
    """Write an equation within a sentence."""
    writer.body.append(tex2mathml(node.astext()))
    raise nodes.SkipNode


def on_lines_of_its_own(writer: HTML5Translator, node: nodes.math_block) -> None:
    """Write an equation between two paragraphs."""
    writer.body.append(f'<div class="equation">{tex2mathml(node.astext(), as_block=True)}</div>')
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Register how equations are written."""
    app.add_html_math_renderer("mathml", (in_a_line, None), (on_lines_of_its_own, None))
