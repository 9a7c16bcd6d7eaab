"""A rig that was left energised and cannot be read back: a person confirms it at the panel."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from e2e.helpers_supply import SupplyLab
from e2e.panel.helpers_screen import NAME, running_panel
from rigrunner.api.member import Member
from rigrunner.rig_state import RigMarks, read_marker
from rigrunner.rig_state.marker import DriveMark, Owner


@pytest.mark.thorough
def test_person_confirms_by_name_that_the_rig_is_safe(new_screen, tmp_path):
    lab = SupplyLab(tmp_path / "supply_lab")
    owner = Owner("supply", str(lab.station), "STEPS", 1, "bench", "2026-03-01T12:00:00.000Z")
    RigMarks(owner, ["psu"])._add(DriveMark(Member("psu", "voltage"), "V", 0.0, 40.0))
    lab.state.unlink()  # the supply does not answer
    with running_panel(lab.folder) as panel:
        screen = new_screen(panel)
        page = screen.page
        screen.open()
        page.locator(".item", has_text="STEPS").click()
        page.get_by_role("button", name="Next", exact=True).click()
        screen.check_rig(ready=False)
        light = page.locator(".light.fail", has_text="not read back as safe")
        expect(light).to_contain_text("confirm there that it is safe")
        assert "rigrunner" not in light.inner_text()
        light.get_by_role("button", name="It is safe").click()
        page.get_by_role("button", name="The rig is safe").click()  # without a reason
        expect(page.locator("#dialog-text-note")).not_to_be_empty()
        page.locator("#dialog-text").fill("unplugged")
        page.keyboard.press("Enter")
        expect(page.locator(".light.warn", has_text="not read back as safe")).to_contain_text(
            f"{NAME} says that it is safe: unplugged"
        )
        assert f"{NAME} says that it is safe: unplugged" in read_marker("supply").safe_by
