"""What of a run can be followed over many: its result, or what it found of its rig."""

from __future__ import annotations

from dataclasses import dataclass

RESULTS = {"torque": ("torque_nm", "expanded_nm"), "raw_peak": ("raw_peak_nm", "")}
"""Columns of a run, and of a set-point: the value and its expanded uncertainty."""
SHORT = {"J": "inertia", "fn": "natural frequency", "damping": "damping ratio"}
"""Short names of the rig's figures."""
ZERO = "zero"


@dataclass(frozen=True)
class Quantity:
    """A result of runs, or a figure of their rigs as the archive has it: 'name', 'source/name'."""

    name: str

    @property
    def is_result(self) -> bool:
        """Whether it is a result; else a figure of the rig."""
        return self.name in RESULTS

    @property
    def is_zero(self) -> bool:
        """Whether it is a zero reading, which depends on no mandrel."""
        return self.name == ZERO or self.name.startswith(f"{ZERO}/")

    def fits(self, source: str, name: str) -> bool:
        """Tell whether a figure of the archive is this one."""
        asked = SHORT.get(self.name, self.name)
        return asked in {name, f"{source}/{name}"} or (asked == ZERO == source)
