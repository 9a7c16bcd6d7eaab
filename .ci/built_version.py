"""Tells a wheel its version, which the tags of git told the build.

The package reads a file of its own: to look its distribution up would cost each command 15 ms. The
file goes into the wheel alone, never among the sources, where it would be out of date at once.
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class BuiltVersion(BuildHookInterface[Any]):
    """Puts `rigrunner/_version.py` into a wheel that is not an editable one."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Write the file beside the sources' folder, and name it to the build."""
        if version == "editable":
            return
        handle, name = tempfile.mkstemp(suffix=".py")
        os.close(handle)
        self._file = Path(name)
        text = (
            f'"""Written when the wheel was built."""\n\n__version__ = "{self.metadata.version}"\n'
        )
        self._file.write_text(text, encoding="utf-8")
        self._file.chmod(0o644)  # as the other files of the wheel
        build_data["force_include"][name] = "rigrunner/_version.py"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Take the file away again."""
        if version != "editable":
            self._file.unlink()
