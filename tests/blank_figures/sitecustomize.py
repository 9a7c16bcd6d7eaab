"""Leaves figures blank in programs that tests start: this folder is on their PYTHONPATH.

It is what helpers_figures does in the process of the tests. A test that looks at the figures of
such a program takes the folder off the path. Nor do these programs wait for the disk.
"""

import os
import sys
from importlib.machinery import PathFinder

os.fsync = os.fstat  # as in conftest.py
BLANK = b'<svg xmlns="http://www.w3.org/2000/svg"/>'


def paint_later(canvas):
    """Paint a figure, and import matplotlib, when something other than its SVG is asked for."""
    draw = canvas.draw
    canvas.draw = lambda *given, **more: canvas.Plot(
        given[0], Later(lambda: draw(*given, **more).figure)
    )
    canvas.Plot.svg = BLANK


class Later:
    """What is made when it is looked at."""

    def __init__(self, make):
        self._make = make

    def __getattr__(self, name):
        return getattr(self._make(), name)


class Finder:
    """Finds the module that draws figures, and changes it once it is loaded."""

    @classmethod
    def find_spec(cls, name, path=None, target=None):
        """Return where that module is, with more to do once it is loaded."""
        if name != "rigrunner.plots.canvas":
            return None
        spec = PathFinder.find_spec(name, path, target)
        load = spec.loader.exec_module

        def load_and_change(module):
            load(module)
            paint_later(module)

        spec.loader.exec_module = load_and_change
        return spec


sys.meta_path.insert(0, Finder)
