// To issue a certificate on a run: what ISO/IEC 17025 asks for and no run knows, and who authorises it.

import { personName, post } from "../client.js";
import { takeControl } from "../steer.js";
import { fill, h } from "../dom.js";
import { said, t } from "../texts.js";
import { field, filledIn } from "./field.js";
import { problemList, refusedWords } from "./notices.js";
import { working } from "./working.js";

const KEPT = "rigrunner.order";
const ORDER = ["customer", "customer_contact", "item", "item_condition", "received"];
// What a run knows where its procedure asks for it: field of the order, and input of the run.
const FROM_RUN = [["item_id", "specimen"], ["operator", "operator"]];

// What was issued, with its files.
export function issuedWords(made) {
  return [h("p", { class: "good-text" }, t("certificate.done", { number: made.number })),
    h("ul", { class: "files" }, made.files.map((file) => h("li", {}, h("a", { href: file.url, target: "_blank", rel: "noopener" }, file.name)))),
    ...made.notes.map((note) => h("p", { class: "soft" }, said(note)))];
}

// Shows why it was not: beside the field that it is about, where that is known, else in `place`.
export function refuse(error, fields, place) {
  const { field: about } = error.problems?.find(({ field: name }) => fields[name]) ?? {};
  if (!about) {
    fill(place, refusal(error));
    return;
  }
  fields[about].refuse(refusedWords(error));
  fields[about].control.focus();
}

// The same as a whole, where there is no such field.
export function refusal(error) {
  return [h("p", { class: "bad-text" }, said(error.message)), error.hint ? h("p", { class: "hint" }, said(error.hint)) : null, problemList(error.problems ?? [])];
}

// The specimens of one order come one after the other: what was said of it is kept in this tab.
function keptOrder() {
  try {
    return JSON.parse(sessionStorage.getItem(KEPT)) ?? {};
  } catch {
    return {};
  }
}

function textField(name, value, { type = "text", required = false } = {}) {
  return field(t(`certificate.${name}`), h("input", { type, id: `certificate-${name}`, value, required, autocomplete: "off" }));
}

// `issued` is called once a certificate was issued.
export function certificateForm(run, inputs, issued) {
  const kept = keptOrder();
  const unknown = FROM_RUN.filter(([, input]) => !inputs[input]).map(([name]) => name);
  const order = Object.fromEntries([...unknown, ...ORDER].map((name) => [name, textField(name, kept[name] ?? "", { type: name === "received" ? "date" : "text", required: true })]));
  const by = textField("by", personName(), { required: true });
  const role = textField("role", kept.role ?? "");
  const language = h("select", { id: "certificate-language" }, ["en", "de"].map((code) => h("option", { value: code }, t(`language.${code}`))));
  const specimen = h("input", { type: "checkbox", id: "certificate-specimen", checked: true });
  const isSpecimen = field(t("certificate.specimen"), specimen, { kind: "ticked" });
  const copy = textField("copy", "");
  const fields = { ...order, authorised_by: by, role, not_for_certification: isSpecimen, further_copy: copy };
  const told = h("div", { class: "told", role: "status" });
  const send = h("button", { type: "submit", class: "button primary big" }, t("certificate.issue"));
  const form = h("form", { class: "inputs", novalidate: true, onsubmit: submit },
    Object.values(order).map((each) => each.element), by.element, role.element,
    field(t("certificate.language"), language).element, isSpecimen.element, copy.element, send, told);

  async function submit(event) {
    event.preventDefault();
    fill(told);
    for (const each of Object.values(fields)) each.refuse("");
    if (!filledIn([...Object.values(order), by])) return;
    const given = Object.fromEntries(Object.entries(order).map(([name, each]) => [name, each.value()]));
    const { item_id: _, ...next } = given;
    sessionStorage.setItem(KEPT, JSON.stringify({ ...next, role: role.value() }));
    const body = { authorised_by: by.value(), role: role.value(), language: language.value, not_for_certification: specimen.checked, further_copy: copy.value(), order: given };
    send.disabled = true;
    try {
      if (!(await takeControl(by.value()))) return;
      tellIssued(await working(told, t("certificate.issuing"), () => post(`runs/${encodeURIComponent(run)}/certificate`, body)));
      issued();
    } catch (error) {
      refuse(error, fields, told);
    } finally {
      send.disabled = false;
    }
  }

  function tellIssued(made) {
    fill(told, issuedWords(made));
  }

  return h("section", { class: "card" }, h("details", {}, h("summary", {}, h("h2", {}, t("certificate.title"))), form));
}
