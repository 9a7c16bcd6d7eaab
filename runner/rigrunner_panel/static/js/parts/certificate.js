// To issue a certificate on a run: what ISO/IEC 17025 asks for and no run knows, and who authorises it.

import { personName, post } from "../client.js";
import { takeControl } from "../steer.js";
import { fill, h } from "../dom.js";
import { translate, t } from "../texts.js";
import { field, filledIn, textField } from "./field.js";
import { problemList, refusedWords } from "./notices.js";
import { working } from "./working.js";

const STORAGE_KEY = "rigrunner.order";
const ORDER = ["customer", "customer_contact", "item", "item_condition", "received"];
// What a run knows where its procedure asks for it: field of the order, and input of the run.
const FROM_RUN = [["item_id", "specimen"], ["operator", "operator"]];

export function fileList(files) {
  return h("ul", { class: "files" }, files.map((file) => h("li", {}, h("a", { href: file.url, target: "_blank", rel: "noopener" }, file.name))));
}

// What was issued, with its files.
export function issuedWords(certificate) {
  return [h("p", { class: "good-text" }, t("certificate.done", { number: certificate.number })),
    fileList(certificate.files),
    ...certificate.notes.map((note) => h("p", { class: "soft" }, translate(note)))];
}

// Shows an error beside its field if that is known, or else in `place`.
export function refuse(error, fields, place) {
  const { field: about } = error.problems?.find(({ field: name }) => fields[name]) ?? {};
  if (!about) {
    fill(place, refusal(error));
    return;
  }
  fields[about].refuse(refusedWords(error));
  fields[about].control.focus();
}

// An error without a field.
export function refusal(error) {
  return [h("p", { class: "bad-text" }, translate(error.message)), error.hint ? h("p", { class: "hint" }, translate(error.hint)) : null, problemList(error.problems ?? [])];
}

// The specimens of one order come one after the other: its entries are stored in this tab.
function storedOrder() {
  try {
    return JSON.parse(sessionStorage.getItem(STORAGE_KEY)) ?? {};
  } catch {
    return {};
  }
}

function orderField(name, value, more = {}) {
  return textField(`certificate-${name}`, t(`certificate.${name}`), { value, ...more });
}

// `issued` is called once a certificate was issued.
export function certificateForm(run, inputs, issued) {
  const stored = storedOrder();
  const unknown = FROM_RUN.filter(([, input]) => !inputs[input]).map(([name]) => name);
  const order = Object.fromEntries([...unknown, ...ORDER].map((name) => [name, orderField(name, stored[name] ?? "", { type: name === "received" ? "date" : "text", required: true })]));
  const by = orderField("by", personName(), { required: true });
  const role = orderField("role", stored.role ?? "");
  const language = h("select", { id: "certificate-language" }, ["en", "de"].map((code) => h("option", { value: code }, t(`language.${code}`))));
  const specimen = h("input", { type: "checkbox", id: "certificate-specimen", checked: true });
  const isSpecimen = field(t("certificate.specimen"), specimen, { kind: "ticked" });
  const copy = orderField("copy", "");
  const fields = { ...order, authorised_by: by, role, not_for_certification: isSpecimen, further_copy: copy };
  const status = h("div", { class: "told", role: "status" });
  const send = h("button", { type: "submit", class: "button primary big" }, t("certificate.issue"));
  const form = h("form", { class: "inputs", novalidate: true, onsubmit: submit },
    Object.values(order).map((input) => input.element), by.element, role.element,
    field(t("certificate.language"), language).element, isSpecimen.element, copy.element, send, status);

  async function submit(event) {
    event.preventDefault();
    fill(status);
    for (const input of Object.values(fields)) input.refuse("");
    if (!filledIn([...Object.values(order), by])) return;
    const values = Object.fromEntries(Object.entries(order).map(([name, input]) => [name, input.value()]));
    const { item_id: _, ...next } = values;
    sessionStorage.setItem(STORAGE_KEY, JSON.stringify({ ...next, role: role.value() }));
    const body = { authorised_by: by.value(), role: role.value(), language: language.value, not_for_certification: specimen.checked, further_copy: copy.value(), order: values };
    send.disabled = true;
    try {
      if (!(await takeControl(by.value()))) return;
      fill(status, issuedWords(await working(status, t("certificate.issuing"), () => post(`runs/${encodeURIComponent(run)}/certificate`, body))));
      issued();
    } catch (error) {
      refuse(error, fields, status);
    } finally {
      send.disabled = false;
    }
  }

  return h("section", { class: "card" }, h("details", {}, h("summary", {}, h("h2", {}, t("certificate.title"))), form));
}
