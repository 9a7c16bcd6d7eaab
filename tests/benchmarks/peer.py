"""Programs of other projects, each measured by a script in their environment."""

from __future__ import annotations

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parent / "peers"
PATIENCE_S = 600


@dataclass(frozen=True)
class Peers:
    """An environment with the extra `peers`; without one, every peer is skipped with a note."""

    python: Path | None = None

    def run(self, script: str, *arguments: object) -> tuple[list[float], str]:
        """Return the numbers of the last line that the script prints, or none and the reason."""
        if self.python is None or not self.python.exists():
            return [], "skipped: not installed"
        command = [self.python, "-E", SCRIPTS / f"{script}.py", *map(str, arguments)]
        try:
            process = subprocess.run(
                command, capture_output=True, text=True, timeout=PATIENCE_S, check=False
            )
        except subprocess.TimeoutExpired:
            return [], f"failed: not done within {PATIENCE_S} s"
        message = (process.stderr.strip().splitlines() or [f"exit {process.returncode}"])[-1]
        if message.startswith("ModuleNotFoundError"):
            return [], f"skipped: not installed ({message.partition(': ')[2]})"
        if process.returncode:
            return [], f"failed: {message}"
        return [float(value) for value in json.loads(process.stdout.strip().splitlines()[-1])], ""

    def versions(self, packages: list[str]) -> str:
        """Return the installed packages with their versions."""
        if self.python is None or not self.python.exists():
            return "not installed"
        script = (
            "import importlib.metadata as m\n"
            "for name in {d.name.lower() for d in m.distributions()} & set("
            f"{packages!r}): print(name, m.version(name))"
        )
        process = subprocess.run(
            [self.python, "-E", "-c", script], capture_output=True, text=True, check=False
        )
        return ", ".join(sorted(process.stdout.splitlines())) or "none"
