"""A lab with a compensation of its own, which is changed on purpose."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from typing import TYPE_CHECKING

from helpers_workflow import station_file
from rigrunner.workflow.new_plugin import NewPlugin

if TYPE_CHECKING:
    from pathlib import Path

METHOD = "own_method"
ANALYSIS = f"""rigrunner: analysis/1
analysis:
  compensations: [template_inverse, {METHOD}]
  primary: {METHOD}
"""
DIFFERENCE = "model_of(raw.value - rig.value, effects"


@dataclass(frozen=True)
class Lab:
    folder: Path

    @property
    def plugin(self):
        return self.folder / "plugins" / f"{METHOD}.py"

    @property
    def golden(self):
        return self.folder / "golden"

    @property
    def words(self):
        """Options by which a command analyses with the lab's own method."""
        return ["--station", self.folder / "station.yaml", "--analysis", self.folder / "own.yaml"]

    def change(self, difference):
        """Write another difference into the method."""
        text = self.plugin.read_text(encoding="utf-8")
        assert DIFFERENCE in text
        changed = text.replace(DIFFERENCE, f"model_of({difference}, effects")
        self.plugin.write_text(changed, encoding="utf-8")


def lab_in(folder, runs):
    """Make a lab with a method of its own and copies of these runs."""
    (folder / "plugins").mkdir(parents=True)
    station_file(folder, ("id: simulated\n", "id: simulated\nplugins: plugins\n"))
    (folder / "own.yaml").write_text(ANALYSIS, encoding="utf-8")
    for run in runs:
        shutil.copytree(run, folder / "runs" / run.name)
    lab = Lab(folder)
    lab.plugin.write_text(NewPlugin("compensation", METHOD).module(), encoding="utf-8")
    return lab
