// Small questions. They are no modal dialogs: the stop button stays within reach.

import { button, h } from "../dom.js";
import { t } from "../texts.js";

let host = null;
let dismiss = () => {};

export function dialogHost() {
  host = h("div", { class: "dialogs" });
  return host;
}

// Puts away what is asked, as when the page is left that it was asked on.
export function dismissDialog() {
  dismiss();
}

// Shows a form; resolves with what `read` gives, or null where it was put away.
function ask(title, fields, { confirm, read, kind = "primary", check = () => true }) {
  const before = document.activeElement;
  return new Promise((resolve) => {
    const end = (answer) => {
      box.remove();
      dismiss = () => {};
      before?.focus?.();
      resolve(answer);
    };
    const accept = button(confirm, () => form.requestSubmit(), { kind });
    const form = h("form", { class: "dialog-form" }, fields, h("div", { class: "row end" },
      button(t("dialog.cancel"), () => end(null)), accept));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      if (check()) end(read());
    });
    const heading = h("h2", { id: "dialog-title" }, title);
    const box = h("section", { class: "dialog", role: "dialog", "aria-labelledby": "dialog-title" }, heading, form);
    box.addEventListener("keydown", (event) => {
      if (event.key === "Escape") {
        event.stopPropagation();
        end(null);
      }
    });
    dismiss();
    dismiss = () => end(null);
    host.replaceChildren(box);
    (form.querySelector("input, textarea, select") ?? accept).focus();
  });
}

function textField(label, { value = "", required = true, rows = 0 } = {}) {
  const input = rows
    ? h("textarea", { rows, id: "dialog-text", value, required })
    : h("input", { type: "text", id: "dialog-text", value, required, autocomplete: "off" });
  return { input, row: h("div", { class: "field" }, h("label", { for: "dialog-text" }, label), input) };
}

export function askName(value, { title = t("dialog.name.title"), confirm = t("dialog.name.take") } = {}) {
  const { input, row } = textField(t("dialog.name.label"), { value });
  return ask(title, [row], { confirm, read: () => input.value.trim(), check: () => input.value.trim() });
}

export function askReason(title, { confirm, kind = "primary", required = true }) {
  const { input, row } = textField(t("dialog.reason"), { required });
  return ask(title, [row], { confirm, kind, read: () => input.value.trim(), check: () => !required || input.value.trim() });
}

export function askText(title, label, { value = "", confirm }) {
  const { input, row } = textField(label, { value });
  return ask(title, [row], { confirm, read: () => input.value.trim(), check: () => input.value.trim() });
}

export function confirmTakeOver(name) {
  const text = h("p", {}, t("dialog.takeover.text", { name }));
  return ask(t("dialog.takeover.title", { name }), [text], { confirm: t("dialog.takeover.yes"), read: () => true });
}

export function askForm(title, rows, options) {
  return ask(title, rows, options);
}
