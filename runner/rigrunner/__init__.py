"""Rigrunner: a plugin-based runner of laboratory test procedures.

For notebooks and scripts see `rigrunner_fleet`, for plugins `rigrunner.api`.
"""

import sys

from rigrunner.moved import MovedModules

try:
    from rigrunner._version import __version__  # a wheel has it: .ci/built_version.py
except ModuleNotFoundError:
    __version__ = "0.1.0+source"  # sources may be at any commit, so no tag names their version

sys.meta_path.append(MovedModules())
