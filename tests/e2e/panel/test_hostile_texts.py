"""Texts that are scripts, typed or sent anywhere: each page shows them as text."""

from __future__ import annotations

import httpx
import pytest
from playwright.sync_api import expect

HOSTILE = '<img src=x onerror="window.hit=1"><script>window.hit=1</script>'
PROBE = """
window.hits = [];
document.addEventListener("securitypolicyviolation", (event) => hits.push(event.blockedURI));
"""
PAGES = ("rigs", "", "queue", "procedures", "procedures/hostile.yaml", "history", "trends", "run")
CERTAIN = ("rigs", "queue", "procedures")
"""Pages that certainly show such a text, so that the test need not wait."""


def hostile_lab(lab):
    """Add a station and a procedure whose titles are scripts."""
    station = (lab / "station.yaml").read_text(encoding="utf-8")
    lines = [
        f"title: '{HOSTILE}'" if line.startswith("title:") else line
        for line in station.replace("id: bench-1", "id: bench-hostile").splitlines()
    ]
    (lab / "hostile_station.yaml").write_text("\n".join(lines), encoding="utf-8")
    procedure = (lab / "procedures/quick_no_load.yaml").read_text(encoding="utf-8")
    lines = [
        f"title: '{HOSTILE}'" if line.startswith("title:") else line
        for line in procedure.replace("id: QUICK-NL", "id: HOSTILE").splitlines()
    ]
    (lab / "hostile.yaml").write_text("\n".join(lines), encoding="utf-8")


@pytest.mark.thorough
def test_hostile_texts_are_shown_as_text(new_screen, lab, panel):
    hostile_lab(lab)
    pair = {"procedure": "procedures/quick_torque.yaml", "station": "hostile_station.yaml"}
    headers = {"X-Rigrunner-Client": "client-mallory"}
    with httpx.Client(base_url=f"{panel.url}api/v1/", headers=headers, timeout=60) as client:
        rig = {"rig": pair["station"]}
        client.post("control", json={"name": HOSTILE[:90]}, params=rig).raise_for_status()
        inputs = {"specimen": HOSTILE, "type": HOSTILE, "lot": HOSTILE, "operator": HOSTILE}
        proposal = {**pair, "inputs": inputs}
        client.post("queue/propose", json=proposal, params=rig).raise_for_status()
        hold = {"entry": 1, "reason": HOSTILE}
        client.post("queue/hold", json=hold, params=rig).raise_for_status()
        edit = {"procedure": "hostile.yaml", "by": HOSTILE[:90]}
        client.post("procedures/edit", json=edit).raise_for_status()
        screen = new_screen()
        page = screen.page
        page.add_init_script(PROBE)
        for place in PAGES:
            page.goto("about:blank")
            page.goto(f"{panel.url}?rig={pair['station']}#/{place}")
            page.wait_for_selector("header .chip:not(.disconnected)")
            if place in CERTAIN:
                expect(page.locator("main")).to_contain_text("onerror")
            else:
                page.wait_for_timeout(500)
            assert page.evaluate("[window.hit, hits]") == [None, []], place
            assert page.locator("main img[src=x]").count() == 0, place
