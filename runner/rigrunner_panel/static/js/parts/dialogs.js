// Small questions. They are no modal dialogs: the stop button stays within reach.

import { button, h } from "../dom.js";
import { filledIn, textField } from "./field.js";
import { keepScansOut } from "./scanner.js";
import { t } from "../texts.js";

let host = null;
let dismiss = () => {};

export function dialogHost() {
  host = h("div", { class: "dialogs" });
  return host;
}

// Closes the open dialog, for example when its page is left.
export function dismissDialog() {
  dismiss();
}

// Shows a form; resolves with the result of `read` once `check` allows it, or null if it was closed.
export function askForm(title, fields, { confirm, read, kind = "primary", check = () => true, scans = false }) {
  const before = document.activeElement;
  return new Promise((resolve) => {
    const end = (answer) => {
      box.remove();
      dismiss = () => {};
      before?.focus?.();
      resolve(answer);
    };
    const accept = button(confirm, () => form.requestSubmit(), { kind });
    const form = h("form", { class: "dialog-form", novalidate: true }, fields, h("div", { class: "row end" },
      button(t("dialog.cancel"), () => end(null)), accept));
    form.addEventListener("submit", async (event) => {
      event.preventDefault();
      accept.disabled = true; // a second click waits for the answer to the first one
      const allowed = await check();
      accept.disabled = false;
      if (allowed) end(read());
    });
    const heading = h("h2", { id: "dialog-title" }, title);
    const box = h("section", { class: "dialog", role: "dialog", tabindex: "-1", "aria-labelledby": "dialog-title" }, heading, form);
    box.addEventListener("keydown", (event) => {
      if (event.key === "Escape") {
        event.stopPropagation();
        end(null);
      }
    });
    if (!scans) keepScansOut(box, { fields: true });
    dismiss();
    dismiss = () => end(null);
    host.replaceChildren(box);
    // not on a button: the Enter of a scanner, which is a keyboard, would press it
    const first = form.querySelector("input, textarea, select");
    (first ?? box).focus();
    first?.select?.(); // what is typed or scanned takes the place of what stands there
  });
}

// Asks for one text, which may be left empty where it is not required.
async function askOne(title, label, { value = "", required = true, confirm, kind, scans }) {
  const text = textField("dialog-text", label, { value, required });
  return askForm(title, [text.element], { confirm, kind, scans, read: text.value, check: () => !required || filledIn([text]) });
}

export function askName({ title = t("dialog.name.title"), confirm = t("dialog.name.take"), value = "" } = {}) {
  return askOne(title, t("dialog.name.label"), { confirm, value, scans: true }); // as from a badge
}

export function askReason(title, options) {
  return askOne(title, t("dialog.reason"), options);
}

export function askText(title, label, options) {
  return askOne(title, label, options);
}

export function confirmTakeOver(name) {
  const text = h("p", {}, t("dialog.takeover.text", { name }));
  return askForm(t("dialog.takeover.title", { name }), [text], { confirm: t("dialog.takeover.yes"), read: () => true });
}
