"""Certificates in the panel: issued, refused twice, verified, amended, signed and withdrawn."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from e2e.panel.helpers_screen import running_panel
from helpers_cli import call

ORDER = {
    "Customer": "A customer", "Customer's address": "1 Street", "Item tested": "Bearing",
    "Condition when received": "as new", "Received on": "2026-01-01",
}  # fmt: skip


@pytest.mark.thorough
def test_certificate_is_issued_verified_amended_signed_and_withdrawn(  # noqa: PLR0915  (a walk)
    new_screen, lab, tmp_path
):
    key = tmp_path / "key.pem"
    assert call("sign", "--new-key", key).code == 0
    with running_panel(lab, options=("--signing-key", str(key))) as panel:
        screen = new_screen(panel)
        run = next(run.name for run in panel.runs.iterdir() if "QUICK-ST" in run.name)
        screen.open(f"#/runs/{run}")
        page = screen.page
        page.get_by_role("heading", name="Issue a certificate").click()
        for label, text in ORDER.items():
            page.get_by_label(label, exact=True).fill(text)
        page.get_by_label("Authorised by").fill("Ann Jones")
        issue = page.get_by_role("button", name="Issue", exact=True)
        page.get_by_label("Item tested", exact=True).fill(" ")
        page.get_by_label("Received on", exact=True).fill("2030-01-01")
        issue.click()  # each refusal is at its field, in the words of the screen
        expect(page.locator("#certificate-item-note")).to_have_text("must not be empty")
        expect(page.locator("#certificate-item")).to_be_focused()
        page.get_by_label("Item tested", exact=True).fill("Bearing")
        expect(page.locator("#certificate-item-note")).to_have_text("")
        issue.click()
        note = page.locator("#certificate-received-note")
        expect(note).to_contain_text("after the test, which began on 20")
        expect(note).not_to_contain_text("--")
        expect(page.locator("form.inputs .told")).to_be_empty()
        page.get_by_label("Received on", exact=True).fill("2026-01-01")
        expect(note).to_have_text("")
        issue.click()  # by the name that was typed above, not asked for again
        first = page.locator(".issued").first
        expect(first).to_contain_text("not for certification")
        page.get_by_role("button", name="Issue", exact=True).click()
        refused = page.locator("#certificate-copy-note")
        expect(refused).to_contain_text("it was issued on")
        expect(page.locator("#certificate-copy")).to_be_focused()

        first.get_by_role("button", name="Verify").click()
        expect(first.locator(".told")).to_contain_text("Match:")
        pending = []
        page.route("**/verify*", lambda route: pending.extend([route]))
        first.get_by_role("button", name="Verify").click()  # its answer comes after the amendment
        first.get_by_role("button", name="Amend").click()
        page.locator(".dialog").get_by_role("button", name="Amend").click()
        expect(page.locator("#amend-reason-note")).to_have_text("must not be empty")
        page.get_by_label("Reason", exact=True).fill("Another address")
        page.locator("#amend-customer_contact").fill("2 Street")
        page.locator(".dialog").get_by_role("button", name="Amend").click()
        expect(page.locator(".issued")).to_have_count(2)
        expect(first).to_contain_text("replaced by")
        expect(first.get_by_role("button", name="Amend")).to_have_count(0)
        pending[0].continue_()
        page.unroute("**/verify*")
        expect(first.locator(".told")).to_contain_text("REPLACED")
        second = page.locator(".issued").nth(1)
        expect(second).to_contain_text("Another address")
        second.get_by_role("button", name="Sign").click()
        page.locator(".dialog").get_by_role("button", name="Sign").click()
        expect(second).to_contain_text("signed")
        second.get_by_role("button", name="Verify").click()
        expect(second.locator(".told")).to_contain_text("Match:")
        page.get_by_role("button", name="Verify this run").click()
        expect(page.locator(".card > .told")).to_contain_text("Match:")
        assert len(list((panel.runs / run).glob("*.sig.json"))) == 1

        second.get_by_role("button", name="Withdraw").click()
        page.get_by_label("Reason", exact=True).fill("wrong item")
        page.get_by_label("Who withdraws it").fill("Z. Head")
        page.locator(".dialog").get_by_role("button", name="Withdraw").click()
        expect(page.locator(".card > .told")).to_contain_text(".withdrawn.json")
        expect(second.get_by_role("button", name="Withdraw")).to_have_count(0)
        expect(second).to_contain_text("withdrawn by Z. Head on 20")
        second.get_by_role("button", name="Verify").click()
        expect(second.locator(".told")).to_contain_text("WITHDRAWN")
