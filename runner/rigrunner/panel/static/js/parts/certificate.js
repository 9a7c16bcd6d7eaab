// To issue a certificate on a run: who authorises it, in which language.

import { personName, post } from "../client.js";
import { takeControl } from "../steer.js";
import { button, fill, h } from "../dom.js";
import { t } from "../texts.js";
import { problemList } from "./notices.js";

export function certificateForm(run, issued) {
  const by = h("input", { type: "text", id: "certificate-by", value: personName(), autocomplete: "off", required: true });
  const role = h("input", { type: "text", id: "certificate-role", autocomplete: "off" });
  const customer = h("input", { type: "text", id: "certificate-customer", autocomplete: "off" });
  const language = h("select", { id: "certificate-language" }, ["en", "de"].map((code) => h("option", { value: code }, t(`language.${code}`))));
  const specimen = h("input", { type: "checkbox", id: "certificate-specimen", checked: true });
  const told = h("div", { class: "told", role: "status" });
  const field = (id, key, control) => h("div", { class: "field" }, h("label", { for: id }, t(key)), control);
  const send = button(t("certificate.issue"), () => form.requestSubmit(), { kind: "primary" });
  const form = h("form", { class: "inputs", onsubmit: submit },
    field("certificate-by", "certificate.by", by), field("certificate-role", "certificate.role", role),
    field("certificate-customer", "certificate.customer", customer), field("certificate-language", "certificate.language", language),
    h("label", { class: "check", for: "certificate-specimen" }, specimen, h("span", {}, t("certificate.specimen"))), send, told);

  async function submit(event) {
    event.preventDefault();
    const order = customer.value.trim() ? { "customer.name": customer.value.trim() } : {};
    const body = { authorised_by: by.value.trim(), role: role.value.trim(), language: language.value, not_for_certification: specimen.checked, order };
    send.disabled = true;
    try {
      if (!(await takeControl())) return;
      const made = await post(`runs/${encodeURIComponent(run)}/certificate`, body);
      fill(told, h("p", { class: "good-text" }, t("certificate.done", { number: made.number })),
        h("ul", { class: "files" }, made.files.map((file) => h("li", {}, h("a", { href: file.url, target: "_blank", rel: "noopener" }, file.name)))),
        made.notes.map((note) => h("p", { class: "soft" }, note)));
    } catch (error) {
      fill(told, h("p", { class: "bad-text" }, error.message), error.hint ? h("p", { class: "hint" }, error.hint) : null, problemList(error.problems ?? []));
    } finally {
      send.disabled = false;
    }
  }

  return h("section", { class: "card" }, h("details", {}, h("summary", {}, h("h2", {}, t("certificate.title"))), form));
}
