// To issue a certificate on a run: what ISO/IEC 17025 asks for and no run knows, and who authorises it.

import { personName, post } from "../client.js";
import { takeControl } from "../steer.js";
import { fill, h } from "../dom.js";
import { said, t } from "../texts.js";
import { problemList } from "./notices.js";
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

// Why it was not, beside the form.
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

function field(id, key, control) {
  return h("div", { class: "field" }, h("label", { for: id }, t(key)), control);
}

function textInput(id, value, required) {
  const type = id === "certificate-received" ? "date" : "text";
  return h("input", { type, id, value, required, autocomplete: "off" });
}

// `issued` is called once a certificate was issued.
export function certificateForm(run, inputs, issued) {
  const kept = keptOrder();
  const unknown = FROM_RUN.filter(([, input]) => !inputs[input]).map(([name]) => name);
  const order = [...unknown, ...ORDER].map((name) => [name, textInput(`certificate-${name}`, kept[name] ?? "", true)]);
  const by = textInput("certificate-by", personName(), true);
  const role = textInput("certificate-role", kept.role ?? "", false);
  const language = h("select", { id: "certificate-language" }, ["en", "de"].map((code) => h("option", { value: code }, t(`language.${code}`))));
  const specimen = h("input", { type: "checkbox", id: "certificate-specimen", checked: true });
  const copy = textInput("certificate-copy", "", false);
  const told = h("div", { class: "told", role: "status" });
  const send = h("button", { type: "submit", class: "button primary big" }, t("certificate.issue"));
  const form = h("form", { class: "inputs", onsubmit: submit },
    order.map(([name, control]) => field(control.id, `certificate.${name}`, control)),
    field("certificate-by", "certificate.by", by), field("certificate-role", "certificate.role", role),
    field("certificate-language", "certificate.language", language),
    h("label", { class: "check", for: "certificate-specimen" }, specimen, h("span", {}, t("certificate.specimen"))),
    field("certificate-copy", "certificate.copy", copy), send, told);

  async function submit(event) {
    event.preventDefault();
    const given = Object.fromEntries(order.map(([name, control]) => [name, control.value.trim()]));
    const { item_id: _, ...next } = given;
    sessionStorage.setItem(KEPT, JSON.stringify({ ...next, role: role.value.trim() }));
    const body = { authorised_by: by.value.trim(), role: role.value.trim(), language: language.value, not_for_certification: specimen.checked, further_copy: copy.value.trim(), order: given };
    send.disabled = true;
    try {
      if (!(await takeControl())) return;
      tellIssued(await working(told, t("certificate.issuing"), () => post(`runs/${encodeURIComponent(run)}/certificate`, body)));
      issued();
    } catch (error) {
      fill(told, refusal(error));
    } finally {
      send.disabled = false;
    }
  }

  function tellIssued(made) {
    fill(told, issuedWords(made));
  }

  return h("section", { class: "card" }, h("details", {}, h("summary", {}, h("h2", {}, t("certificate.title"))), form));
}
