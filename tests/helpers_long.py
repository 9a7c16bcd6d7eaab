"""Makes any recording too long for memory, by making a block very short."""

from __future__ import annotations

BLOCK = 5000
MODULES = ("blocks", "cycles", "extremes", "order", "pulses", "spikes")


def short_blocks(monkeypatch, block: int = BLOCK) -> None:
    """Take recordings of more than `block` samples in pieces of that size."""
    for name in MODULES:
        monkeypatch.setattr(f"rigrunner.signal.{name}.BLOCK", block)
    monkeypatch.setattr("rigrunner.signal.extremes.CACHED", block)
