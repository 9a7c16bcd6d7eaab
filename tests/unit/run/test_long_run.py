"""A run that is too long for memory has the same result as in memory."""

from __future__ import annotations

from collections import Counter

import pytest

from helpers_long import short_cycles
from rigrunner.documents.certifying.derived_again import refuse_other_numbers
from rigrunner.registry import load_registry
from rigrunner.run.stored import analyse_run
from rigrunner.runfile import read
from rigrunner.runfile.stored_samples import StoredSamples
from rigrunner_bearings.api.torque import TorqueDetails


@pytest.mark.thorough
def test_analysis_by_blocks_equals_analysis_in_memory(quick, monkeypatch):
    in_memory, stored = analyse_run(quick.loaded, load_registry()), read(quick.loaded)
    short_cycles(monkeypatch, 2000)
    monkeypatch.setattr("rigrunner.runfile.entry.IN_MEMORY", 0)
    longest, read_slice = [], StoredSamples.__getitem__
    unpacked, unpack = Counter(), StoredSamples._unpack

    def slice_and_note(self, selection):
        part = read_slice(self, selection)
        longest.append(len(part))
        return part

    def unpack_and_count(self, selection):
        part = unpack(self, selection)
        unpacked[self.place, self.samples] += len(part)
        return part

    monkeypatch.setattr(StoredSamples, "__getitem__", slice_and_note)
    monkeypatch.setattr(StoredSamples, "_unpack", unpack_and_count)
    result = analyse_run(quick.loaded, load_registry())
    assert 0 < max(longest) < 5000 < max(recording.samples for recording in stored.recordings)
    assert unpacked, "and each channel once"
    assert all(count == samples for (_, samples), count in unpacked.items())
    refuse_other_numbers(stored, result)
    assert result.headline.value == pytest.approx(in_memory.headline.value, rel=1e-6)
    assert [(check.name, check.ok, check.text) for check in result.checks] == [
        (check.name, check.ok, check.text) for check in in_memory.checks
    ]
    for mine, other in zip(
        *(TorqueDetails.of(analysis).loaded for analysis in (result, in_memory)), strict=True
    ):
        assert mine.peak_nm.tolist() == other.peak_nm.tolist()
        assert mine.spikes == other.spikes
        assert mine.frequency_hz.value == pytest.approx(other.frequency_hz.value, rel=1e-12)
