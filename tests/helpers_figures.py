"""The figures of reports: most tests have no use for them, and they take longest of a run."""

from __future__ import annotations

import os
from contextlib import contextmanager
from pathlib import Path

import pytest
from matplotlib.backends.backend_svg import FigureCanvasSVG

from rigrunner.plots import panels

BLANK_FIGURES = Path(__file__).parent / "blank_figures"
"""On the PYTHONPATH of programs that tests start."""
_BLANK = b'<svg xmlns="http://www.w3.org/2000/svg"/>'
_PRINT_SVG = FigureCanvasSVG.print_svg
_PAINT = panels.paint


@contextmanager
def blank():
    """Leave figures blank within the block."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(FigureCanvasSVG, "print_svg", lambda _, file, **_more: file.write(_BLANK))
        patch.setattr(panels, "paint", lambda *_, **_more: None)
        yield


@contextmanager
def drawn():
    """Draw figures within the block, though they are left blank around it."""
    path = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(FigureCanvasSVG, "print_svg", _PRINT_SVG)
        patch.setattr(panels, "paint", _PAINT)
        folders = (folder for folder in path if folder != str(BLANK_FIGURES))
        patch.setenv("PYTHONPATH", os.pathsep.join(folders))
        yield
