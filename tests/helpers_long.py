"""Makes any recording too long for memory, by making a block very short."""

from __future__ import annotations

BLOCK = 5000


def short_blocks(monkeypatch, block: int = BLOCK) -> None:
    """Take recordings of more than `block` samples in pieces of that size."""
    for name in ("blocks", "order", "spikes"):
        monkeypatch.setattr(f"rigrunner.signal.{name}.BLOCK", block)
    monkeypatch.setattr("rigrunner.signal.blocks.STEP", block)
    monkeypatch.setattr("rigrunner.signal.extremes.CACHED", block)


def short_cycles(monkeypatch, block: int = BLOCK) -> None:
    """Take recordings of swings in such pieces too."""
    short_blocks(monkeypatch, block)
    for name in ("cycles", "pulses"):
        monkeypatch.setattr(f"rigrunner_bearings.signal.{name}.BLOCK", block)
