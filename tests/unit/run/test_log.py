"""The plain text log of a run, whatever its events contain."""

from __future__ import annotations

import errno
import io

from rigrunner.api.events import Answer, Intervention, MadeSafe
from rigrunner.run.log import RunLog

FORGED = "SN-1\n2026-01-01T00:00:00Z run completed\x1b[8m"


def test_text_with_line_breaks_cannot_forge_an_event(tmp_path):
    stamp = {"seq": 1, "monotonic_s": 0.0, "utc": "2026-03-01T12:00:00Z"}
    with RunLog(tmp_path / "run.log") as log:
        log(Answer(**stamp, step="ask", text=FORGED, by="operator", into="specimen"))
        log(Intervention(**stamp, action="stop", by="panel", subject="", reason=FORGED))
    lines = (tmp_path / "run.log").read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if line.startswith("2026-01-01")] == []
    assert len([line for line in lines if line.startswith("2026-03-01")]) == 2
    assert "\x1b" not in "".join(lines)


def test_read_backs_are_logged_in_readable_units(tmp_path):
    """A monochromator in nm; a run file of 0.1.0 does not state the unit."""
    stamp = {"seq": 1, "monotonic_s": 0.0, "utc": "2026-03-01T12:00:00Z"}
    safe = {"what": "mono", "read_back": {"mono.wavelength": 5e-7, "mono.slit": 0.0}}
    with RunLog(tmp_path / "run.log") as log:
        log(MadeSafe(**stamp, **safe, units={"mono.wavelength": "m", "mono.slit": "m"}))
        log(MadeSafe(**stamp, **safe))
    now, before = (tmp_path / "run.log").read_text(encoding="utf-8").splitlines()
    assert now.endswith("mono is safe: read back mono.wavelength 500 nm, mono.slit 0 m")
    assert before.endswith("mono is safe: read back mono.wavelength 5e-07, mono.slit 0")


def test_log_that_fails_to_close_does_not_end_the_run(tmp_path):
    """A network disk reports then what it could not write; the journal has everything."""

    class Full(io.FileIO):
        def close(self):
            super().close()
            raise OSError(errno.EDQUOT, "Disk quota exceeded")

    with RunLog(tmp_path / "run.log") as log:
        log._file.close()
        log._file = Full(tmp_path / "run.log", "ab")
    assert log._file.closed
