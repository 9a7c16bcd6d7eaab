// The certificates of a run: verified, amended and signed; and the run itself verified.

import { get, personName, post } from "../client.js";
import { button, fill, h } from "../dom.js";
import { localTime } from "../format.js";
import { takeControl } from "../steer.js";
import { said, t } from "../texts.js";
import { issuedWords, refusal, refuse } from "./certificate.js";
import { askForm } from "./dialogs.js";
import { field, filledIn } from "./field.js";
import { working } from "./working.js";

const CHANGES = ["customer", "customer_contact", "item", "item_id", "item_condition", "received", "operator"];
const FINDINGS = [["differences", "bad"], ["replaced", "warn"], ["unproven", "warn"], ["not_recomputed", "warn"], ["unchecked", "warn"], ["information", ""]];

export function certificateList(run) {
  const base = `runs/${encodeURIComponent(run)}`;
  const list = h("div", { class: "stack" });
  const told = h("div", { class: "told", role: "status" });
  const places = new Map(); // what is said of each certificate, by number: stays when the list is read again
  const whole = button(t("certificates.verify_run"), () => verify(`${base}/verify`, told));
  load();

  async function load() {
    const found = await get(`${base}/certificates`).catch(() => ({ items: [], can_sign: false }));
    fill(list, found.items.length ? found.items.map((each) => row(each, found.can_sign)) : h("p", { class: "soft" }, t("certificates.none")));
  }

  function row(item, canSign) {
    if (!places.has(item.number)) places.set(item.number, h("div", { class: "told", role: "status" }));
    const place = places.get(item.number);
    const one = `${base}/certificates/${encodeURIComponent(item.number)}`;
    const marks = [
      item.for_certification ? null : h("span", { class: "mark warn" }, t("certificates.not_for")),
      item.replaced_by ? h("span", { class: "mark warn" }, t("certificates.replaced", { number: item.replaced_by })) : null,
      item.signed ? h("span", { class: "mark pass" }, t("certificates.signed")) : null,
    ];
    return h("div", { class: "issued" },
      h("div", { class: "row" }, h("strong", {}, item.number), marks),
      h("p", { class: "soft" }, t("certificates.by", { time: localTime(item.issued_utc), name: item.by })),
      item.amends ? h("p", { class: "soft" }, t("certificates.amends", { number: item.amends, reason: item.reason })) : null,
      h("ul", { class: "files" }, item.files.map((file) => h("li", {}, h("a", { href: file.url, target: "_blank", rel: "noopener" }, file.name)))),
      h("div", { class: "row" },
        button(t("certificates.verify"), () => verify(`${one}/verify`, place)),
        item.replaced_by ? null : button(t("certificates.amend"), () => amend(item, one)),
        canSign && !item.signed ? button(t("certificates.sign"), () => sign(item, one)) : null),
      place);
  }

  async function verify(path, place) {
    try {
      const found = await working(place, t("certificates.verifying"), () => post(path));
      fill(place, h("p", { class: found.matches ? "good-text" : "bad-text" }, found.matches ? t("certificates.match") : found.conclusion.split("; ").map(said).join("; ")),
        FINDINGS.map(([key, kind]) => found[key].map((text) => h("p", { class: kind ? `${kind}-text` : "soft" }, said(text)))).flat(),
        h("details", {}, h("summary", {}, t("certificates.held", { count: found.held.length })), h("ul", {}, found.held.map((text) => h("li", {}, said(text))))));
    } catch (error) {
      fill(place, refusal(error));
    }
  }

  // Asks for what it needs, and does it: what is refused stands in the form, and the form stays.
  async function change({ title, confirm, what, path, fields, required, body, words, by }) {
    const doing = h("div", { class: "told", role: "status" });
    let made = null;
    await askForm(title, [...Object.values(fields).map((each) => each.element), doing], {
      confirm,
      read: () => true,
      check: async () => {
        fill(doing);
        if (!filledIn(required)) return false;
        try {
          made = (await takeControl(by.value())) ? await working(doing, what, () => post(path, body())) : null;
        } catch (error) {
          refuse(error, fields, doing);
        }
        return made !== null;
      },
    });
    if (!made) return;
    await load();
    fill(told, words(made));
  }

  async function amend(item, one) {
    const reason = textField("amend-reason", t("certificates.reason"), { required: true });
    const by = textField("amend-by", t("certificate.by"), { value: personName(), required: true });
    const order = Object.fromEntries(CHANGES.map((name) => [name, textField(`amend-${name}`, t(`certificate.${name}`), { type: name === "received" ? "date" : "text" })]));
    const hint = { element: h("p", { class: "soft" }, t("certificates.amend_hint")) };
    await change({
      title: t("certificates.amend_title", { number: item.number }), confirm: t("certificates.amend"), what: t("certificate.issuing"), path: `${one}/amend`,
      fields: { hint, reason, authorised_by: by, ...order }, required: [reason, by], by, words: issuedWords,
      body: () => ({ reason: reason.value(), authorised_by: by.value(), order: Object.fromEntries(Object.entries(order).map(([name, each]) => [name, each.value()]).filter(([, value]) => value)) }),
    });
  }

  async function sign(item, one) {
    const by = textField("sign-by", t("certificates.who"), { value: personName(), required: true });
    const passphrase = textField("sign-passphrase", t("certificates.passphrase"), { type: "password" });
    await change({
      title: t("certificates.sign_title", { number: item.number }), confirm: t("certificates.sign"), what: t("certificates.signing"), path: `${one}/sign`,
      fields: { by, passphrase }, required: [by], by, words: () => [h("p", { class: "good-text" }, `${item.number}: ${t("certificates.signed")}`)],
      body: () => ({ by: by.value(), passphrase: passphrase.control.value }),
    });
  }

  return { element: h("section", { class: "card" }, h("h2", {}, t("certificates.title")), list, h("div", { class: "row" }, whole), told), load };
}

function textField(id, label, { type = "text", value = "", required = false } = {}) {
  return field(label, h("input", { type, id, value, required, autocomplete: "off" }));
}
