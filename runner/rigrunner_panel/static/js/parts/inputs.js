// The inputs of a procedure, checked while they are typed. A scanner ends with Enter,
// which goes on to the next field.

import { personName, post } from "../client.js";
import { afterTyping, h, setText } from "../dom.js";
import { shownNumber, typedNumber } from "../format.js";
import { translate, t } from "../texts.js";
import { refusedWords } from "./notices.js";

const OPERATOR = "operator"; // the person's name is already known
const LONGEST = 80;
const TYPING_MS = 200;

export function inputForm(procedure, inputs, values, keep) {
  const fields = inputs.map((input) => field(procedure, input, values[input.name] ?? (input.name === OPERATOR ? personName() : ""), changed));
  const form = {
    element: h("form", { class: "inputs", onsubmit: (event) => event.preventDefault() },
      fields.length ? fields.map((item) => item.element) : h("p", { class: "soft" }, t("setup.no_inputs"))),
    values: () => Object.fromEntries(fields.map((item) => [item.name, item.value()])),
    missing: () => fields.filter((item) => !item.good()).map((item) => item.label),
    toEmpty: () => fields.find((item) => !item.value().trim())?.control.focus(),
    onchange: () => {},
  };

  function changed() {
    keep(form.values());
    form.onchange();
  }

  fields.forEach((item, i) => {
    item.control.addEventListener("keydown", (event) => {
      if (event.key !== "Enter") return;
      event.preventDefault();
      const next = fields[i + 1]?.control;
      if (next) next.focus();
      else item.control.blur();
    });
  });
  return form;
}

function field(procedure, input, value, changed) {
  const id = `input-${input.name}`;
  const [show, read] = input.unit ? [shownNumber, typedNumber] : [String, String];
  const note = h("p", { class: "field-note", id: `${id}-note`, role: "status" }, translate(input.expected));
  const control = input.choices.length
    ? h("select", { id, "aria-describedby": `${id}-note`, onchange: look }, h("option", { value: "" }, t("setup.choose")), input.choices.map((choice) => h("option", { value: choice, selected: choice === value }, choice)))
    : h("input", { type: "text", id, value: show(value), autocomplete: "off", spellcheck: "false", "aria-describedby": `${id}-note`, oninput: later });
  const row = h("div", { class: "field" }, h("label", { for: id }, translate(input.ask)), control, note);
  let good = false;
  let requests = 0;
  const lookLater = afterTyping(look, TYPING_MS);

  function later() {
    good = false;
    changed();
    lookLater();
  }

  async function look() {
    const request = ++requests;
    const text = control.value;
    if (!text.trim()) {
      state("", translate(input.expected));
      return;
    }
    let answer;
    try {
      answer = await post("check-input", { procedure, input: input.name, text: read(text) });
    } catch (error) {
      answer = error;
    }
    if (request !== requests) return;
    if (!answer.ok) state("bad", refusedWords(answer));
    else if (answer.note) state("warn", translate(answer.note), true);
    else state("good", t("setup.taken", { value: show(short(answer.value)) }), true);
  }

  function state(kind, text, ok = false) {
    good = ok;
    row.className = `field ${kind}`;
    control.setAttribute("aria-invalid", String(kind === "bad"));
    setText(note, text);
    changed();
  }

  if (value) look();
  return { element: row, control, name: input.name, label: translate(input.ask), value: () => read(control.value), good: () => good };
}

function short(text) {
  return text.length > LONGEST ? `${text.slice(0, LONGEST)}…` : text;
}
