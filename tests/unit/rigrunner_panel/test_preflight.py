"""The items of a preflight, which leaves every device safe and closed."""

from __future__ import annotations

from collections import namedtuple
from dataclasses import replace

import pytest

from helpers_devices import FakeTester
from rigrunner.api.errors import DeviceTimeoutError
from rigrunner.api.member import Member
from rigrunner.api.units import unit
from rigrunner.plan import Plan
from rigrunner.plan.actions import Interlock
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.run.planning import planned_run
from rigrunner_panel.jobs import preflight
from rigrunner_panel.jobs.preflight_calibrations import calibrations
from rigrunner_panel.jobs.preflight_rig import rig_items

Usage = namedtuple("Usage", "total used free")  # noqa: PYI024  (as shutil has it)


@pytest.fixture(scope="module")
def shipped():
    return planned_run(find_procedure("no_load_inertia_sweep"), find_station("simulated"))


def items_of(shipped, device, *interlocks):
    plan = Plan(shipped.plan.steps, interlocks)
    return rig_items(replace(shipped, devices={"tester": device}, plan=plan))


def load_lock(maximum, **more):
    return Interlock(
        name="load", member=Member("tester", "load"), condition="above it", shown=unit("N"),
        maximum=maximum, **more,
    )  # fmt: skip


def test_good_rig_passes_and_is_left_safe_and_closed(shipped):
    device = FakeTester()
    items = list(items_of(shipped, device, load_lock(2000.0)))
    kinds = [(item.kind, item.name, item.state) for item in items]
    assert kinds == [
        ("device", "tester", "ok"), ("interlock", "load", "ok"), ("zero", "tester.torque", "ok"),
    ]  # fmt: skip
    assert items[0].text == "Fakes tester 1 (simulated)"
    assert device.calls[-2:] == ["make_safe", "close"]
    assert set(device.drives_at.values()) == {0.0}


@pytest.mark.parametrize("overridable", [True, False])
def test_tripped_interlock_fails_and_names_its_effect(shipped, overridable):
    lock = load_lock(500.0, does="make_safe", overridable=overridable)
    (item,) = [item for item in items_of(shipped, FakeTester(), lock) if item.kind == "interlock"]
    assert item.state == "fail"
    assert item.text == "tester.load is 1000 N, above it"
    assert "make safe" in item.fix
    assert item.override == ("interlock load" if overridable else "")


def test_zero_offset_fails_with_its_value(shipped):
    def off(blocks):
        return [replace(b, channels={"torque": b.channels["torque"] + 0.2}) for b in blocks]

    (item,) = [item for item in items_of(shipped, FakeTester(spoil=off)) if item.kind == "zero"]
    assert (item.state, item.override) == ("fail", "zero tester.torque")
    assert item.text.startswith("reads 0.19")
    assert "adjust" in item.fix


@pytest.mark.parametrize("call", ["connect", "stream", "read load"])
def test_failing_device_is_reported_and_made_safe(shipped, call):
    def fails(command):
        if command == call:
            raise DeviceTimeoutError("no answer", hint="look at its cable")

    device = FakeTester(before=fails)
    items = list(items_of(shipped, device, load_lock(2000.0)))
    (failed,) = [item for item in items if item.state == "fail"]
    assert "no answer" in failed.text
    assert failed.fix == "look at its cable"
    assert "make_safe" in device.calls or call == "connect"
    assert device.calls[-1] == "close"


def test_interrupted_preflight_leaves_the_rig_safe(shipped):
    device = FakeTester()
    items = items_of(shipped, device)
    next(items)
    items.close()
    assert device.calls[-2:] == ["make_safe", "close"]


def test_free_disk_space_is_checked(shipped, monkeypatch, tmp_path):
    for free, state, override in ((1, "fail", "disk"), (2e8, "warn", ""), (1e12, "ok", "")):
        monkeypatch.setattr(preflight.shutil, "disk_usage", lambda _, b=free: Usage(0, 0, b))
        item = preflight._disk(shipped, tmp_path / "not" / "there" / "yet")
        assert (item.state, item.override) == (state, override)
        assert bool(item.fix) == (state != "ok")


def test_calibration_due_soon_is_a_warning(tmp_path):
    text = find_station("simulated").read_text(encoding="utf-8")
    today = planned_run(find_procedure("no_load_inertia_sweep"), find_station("simulated")).clock
    soon = today.utc().date().isoformat()
    changed = f"certificate: C-1\n    laboratory: L\n    calibrated: 2020-01-01\n    due: {soon}"
    (tmp_path / "s.yaml").write_text(text.replace("calibration: simulated", changed))
    planned = planned_run(find_procedure("no_load_inertia_sweep"), tmp_path / "s.yaml")
    (item,) = calibrations(planned)
    assert (item.state, item.text) == ("warn", f"SIM-TQ-01: certificate C-1, due {soon}")
