// A field: its label, and below it what is expected, or why what stands in it was refused.

import { h, setText } from "../dom.js";
import { t } from "../texts.js";

export function field(label, control, { hint = "", kind = "" } = {}) {
  const note = h("p", { class: "field-note", id: `${control.id}-note`, role: "status" }, hint);
  const element = h("div", { class: `field ${kind}`.trim() }, h("label", { for: control.id }, label), control, note);
  control.setAttribute("aria-describedby", note.id);

  // "" where nothing is wrong, as after something else was typed.
  function refuse(text) {
    element.classList.toggle("bad", Boolean(text));
    control.setAttribute("aria-invalid", String(Boolean(text)));
    setText(note, text || hint);
  }

  control.addEventListener("input", () => refuse(""));
  return { element, control, refuse, value: () => control.value.trim() };
}

// A field for one line of text.
export function textField(id, label, { type = "text", value = "", required = false } = {}) {
  return field(label, h("input", { type, id, value, required, autocomplete: "off" }));
}

// Marks what was left empty and goes to the first of them; returns whether all is filled in.
export function filledIn(fields) {
  for (const item of fields) item.refuse(item.value() ? "" : t("field.empty"));
  const first = fields.find((item) => !item.value());
  first?.control.focus();
  return !first;
}
