"""A station with a Modbus inverter: the files of the page, run as documented."""

from __future__ import annotations

import pytest

from helpers_cli import call
from helpers_docs import ROOT, code_blocks

PAGE = ROOT / "docs/how-to/drive-a-frequency-inverter.md"


@pytest.fixture
def lab(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for block in code_blocks(PAGE):
        if block.file:
            (tmp_path / block.file).write_text(block.code, encoding="utf-8")
    return tmp_path


def run(*more, station="bench.yaml"):
    return call("run", "try_motor.yaml", "--station", station, "--unattended", *more)


def run_edited(lab, before, after):
    text = (lab / "bench.yaml").read_text(encoding="utf-8")
    assert before in text
    (lab / "changed.yaml").write_text(text.replace(before, after, 1), encoding="utf-8")
    return run(station="changed.yaml")


def test_inverter_communication_is_recorded_and_replayed(lab):
    recorded = run("--record", "tape")
    assert recorded.code == 0, recorded.err
    tape = (lab / "tape/devices/motor.jsonl").read_text(encoding="utf-8")
    assert '"ask":"write 3500 to holding 1"' in tape
    replayed = run("--replay", "tape")
    assert replayed.code == 0, replayed.err
    (first, second) = (call("show", path.name) for path in sorted((lab / "runs").iterdir()))
    for shown in (first, second):
        assert "35                    35               2.15" in shown.out


@pytest.mark.usefixtures("lab")
def test_station_devices_identify_themselves():
    called = call("devices", "bench.yaml")
    assert called.code == 0, called.err
    assert "Rigrunner SIM-VFD" in called.out
    assert "press" in called.out


@pytest.mark.parametrize(
    ("before", "after", "code", "told"),
    [
        ("max: 35 Hz", "max: 700 Hz", 3, "max is 700 Hz: 70000 does not fit into uint16"),
        ("0x0001}", "0x1FFFF}", 3, "got '0x1FFFF', expected 65535 or less"),
        ("holding: 1 ", "reference: 3 ", 3, "reference is 3, expected 1xxxx"),
        ("unit_id: 1 ", "unit_id: 300 ", 3, "unit_id"),
        ("      channels:", "      chanels:", 3, "did you mean 'channels'?"),
        ("simulated: yes ", "simulated: no ", 3, "go together"),
        ("model: SIM-VFD", "model: FC-51", 4, "has the model 'SIM-VFD', expected 'FC-51'"),
        ("holding: 1 ", "holding: 9 ", 4, "holding 9 is number 10 of manuals that count from 1"),
        ("{input: 2,", "{input: 20,", 4, "read input 20"),
        ("max: 35 Hz", "max: 60 Hz", 0, ""),
    ],
)
def test_mistakes_in_the_station_are_reported(lab, before, after, code, told):
    called = run_edited(lab, before, after)
    assert (called.code, told in called.err) == (code, True), called.err
    assert "Traceback" not in called.err
    if code == 3:
        assert "changed.yaml:" in called.err
