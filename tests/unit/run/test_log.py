"""What the plain text log beside a run says, whatever is said to it."""

from __future__ import annotations

from rigrunner.api.events import Answer, Intervention
from rigrunner.run.log import RunLog

FORGED = "SN-1\n2026-01-01T00:00:00Z run completed\x1b[8m"


def test_a_text_of_several_lines_is_no_other_event(tmp_path):
    known = {"seq": 1, "monotonic_s": 0.0, "utc": "2026-03-01T12:00:00Z"}
    with RunLog(tmp_path / "run.log") as log:
        log(Answer(**known, step="ask", text=FORGED, by="operator", into="specimen"))
        log(Intervention(**known, action="stop", by="panel", subject="", reason=FORGED))
    lines = (tmp_path / "run.log").read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if line.startswith("2026-01-01")] == []
    assert len([line for line in lines if line.startswith("2026-03-01")]) == 2
    assert "\x1b" not in "".join(lines)
