// The answers that a procedure asks for, looked at while they are typed. A scanner ends with Enter,
// which goes on to the next field.

import { personName, post } from "../client.js";
import { h, setText } from "../dom.js";
import { shownNumber, typedNumber } from "../format.js";
import { said, t } from "../texts.js";
import { refusedWords } from "./notices.js";

const OPERATOR = "operator"; // who it is was asked once already
const LONGEST = 80;
const TYPING_MS = 200;

export function inputForm(procedure, inputs, given, keep) {
  const fields = inputs.map((input) => field(procedure, input, given[input.name] ?? (input.name === OPERATOR ? personName() : ""), changed));
  const form = {
    element: h("form", { class: "inputs", onsubmit: (event) => event.preventDefault() },
      fields.length ? fields.map((each) => each.element) : h("p", { class: "soft" }, t("setup.no_inputs"))),
    values: () => Object.fromEntries(fields.map((each) => [each.name, each.value()])),
    missing: () => fields.filter((each) => !each.good()).map((each) => each.label),
    toEmpty: () => fields.find((each) => !each.value().trim())?.control.focus(),
    onchange: () => {},
  };

  function changed() {
    keep(form.values());
    form.onchange();
  }

  fields.forEach((each, i) => {
    each.control.addEventListener("keydown", (event) => {
      if (event.key !== "Enter") return;
      event.preventDefault();
      const next = fields[i + 1]?.control;
      if (next) next.focus();
      else each.control.blur();
    });
  });
  return form;
}

function field(procedure, input, value, changed) {
  const id = `input-${input.name}`;
  const [show, read] = input.unit ? [shownNumber, typedNumber] : [String, String];
  const told = h("p", { class: "field-note", id: `${id}-note`, role: "status" }, said(input.expected));
  const control = input.choices.length
    ? h("select", { id, "aria-describedby": `${id}-note`, onchange: look }, h("option", { value: "" }, t("setup.choose")), input.choices.map((choice) => h("option", { value: choice, selected: choice === value }, choice)))
    : h("input", { type: "text", id, value: show(value), autocomplete: "off", spellcheck: "false", "aria-describedby": `${id}-note`, oninput: later });
  const row = h("div", { class: "field" }, h("label", { for: id }, said(input.ask)), control, told);
  let good = false;
  let asked = 0;
  let timer = 0;

  function later() {
    good = false;
    changed();
    clearTimeout(timer);
    timer = setTimeout(look, TYPING_MS);
  }

  async function look() {
    const mine = ++asked;
    const text = control.value;
    if (!text.trim()) {
      state("", said(input.expected));
      return;
    }
    let answer;
    try {
      answer = await post("check-input", { procedure, input: input.name, text: read(text) });
    } catch (error) {
      answer = error;
    }
    if (mine !== asked) return;
    if (!answer.ok) state("bad", refusedWords(answer));
    else if (answer.note) state("warn", said(answer.note), true);
    else state("good", t("setup.taken", { value: show(short(answer.value)) }), true);
  }

  function state(kind, text, ok = false) {
    good = ok;
    row.className = `field ${kind}`;
    control.setAttribute("aria-invalid", String(kind === "bad"));
    setText(told, text);
    changed();
  }

  if (value) look();
  return { element: row, control, name: input.name, label: said(input.ask), value: () => read(control.value), good: () => good };
}

function short(text) {
  return text.length > LONGEST ? `${text.slice(0, LONGEST)}…` : text;
}
