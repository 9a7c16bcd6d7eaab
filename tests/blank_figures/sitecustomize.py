"""Leaves figures blank in programs that tests start: this folder is on their PYTHONPATH.

It is what helpers_figures does in the process of the tests. A test that looks at the figures of
such a program takes the folder off the path.
"""

import sys
from importlib.machinery import PathFinder

NAME = "matplotlib.backends.backend_svg"
BLANK = b'<svg xmlns="http://www.w3.org/2000/svg"/>'


class Finder:
    """Finds the module that writes figures, and takes the writing out of it."""

    @classmethod
    def find_spec(cls, name, path=None, target=None):
        """Return where that module is, with more to do once it is loaded."""
        if name != NAME:
            return None
        spec = PathFinder.find_spec(name, path, target)
        load = spec.loader.exec_module

        def load_and_blank(module):
            load(module)
            module.FigureCanvasSVG.print_svg = lambda _, file, **_more: file.write(BLANK)

        spec.loader.exec_module = load_and_blank
        return spec


sys.meta_path.insert(0, Finder)
