"""A Ctrl-C while a file is written waits for its end: HDF5 would go on with the wrong bytes."""

from __future__ import annotations

import signal
import threading

import h5py
import numpy as np
import pytest

from rigrunner.runfile import read, sealing
from rigrunner.runfile.hdf5 import new_file
from rigrunner.runfile.interrupts import uninterrupted
from rigrunner.runfile.patient_file import PatientFile
from unit.runfile.helpers_runfile import recording, write_run


def ctrl_c():
    signal.raise_signal(signal.SIGINT)


def test_a_file_is_whole_before_the_interrupt_is_taken(tmp_path, monkeypatch):
    plain, presses = PatientFile.seek, []

    def seek(self, *where):
        if len(presses) < 3:
            presses.append(where)
            ctrl_c()
        return plain(self, *where)

    monkeypatch.setattr(PatientFile, "seek", seek)
    values = np.random.default_rng(1).normal(size=50_000)
    with pytest.raises(KeyboardInterrupt), new_file(tmp_path / "a.h5") as file:
        file.create_dataset("x", data=values, chunks=(1000,), compression="gzip")
    assert len(presses) == 3
    with h5py.File(tmp_path / "a.h5") as file:
        assert np.array_equal(file["x"][...], values)


def test_a_run_is_sealed_before_the_interrupt_is_taken(tmp_path, monkeypatch):
    writer = write_run(tmp_path / "run", [recording(samples=200)])
    plain = sealing.write_manifest

    def write_manifest(entry):
        ctrl_c()
        plain(entry)

    monkeypatch.setattr(sealing, "write_manifest", write_manifest)
    with pytest.raises(KeyboardInterrupt):
        writer.seal()
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == ["run.h5"]
    assert read(tmp_path / "run").info.sealed


def test_who_listened_before_is_told_of_each_and_listens_again():
    signals = []
    previous = signal.signal(signal.SIGINT, lambda number, _: signals.append(number))
    try:
        with uninterrupted():
            with uninterrupted():
                ctrl_c()
                ctrl_c()
            assert not signals
        assert signals == [signal.SIGINT] * 2
        ctrl_c()
        assert signals == [signal.SIGINT] * 3
    finally:
        signal.signal(signal.SIGINT, previous)


def test_another_thread_takes_no_signals_and_needs_none_kept_away():
    done = []

    def work():
        with uninterrupted():
            done.append(True)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert done
