// The certificates of a run: verified, amended, withdrawn and signed; and the run itself verified.

import { get, personName, post } from "../client.js";
import { button, fill, h } from "../dom.js";
import { localTime } from "../format.js";
import { takeControl } from "../steer.js";
import { translate, t } from "../texts.js";
import { fileList, issuedWords, refusal, refuse } from "./certificate.js";
import { askForm } from "./dialogs.js";
import { filledIn, textField } from "./field.js";
import { working } from "./working.js";

const CHANGES = ["customer", "customer_contact", "item", "item_id", "item_condition", "received", "operator"];
const FINDINGS = [["differences", "bad"], ["withdrawn", "bad"], ["replaced", "warn"], ["unproven", "warn"], ["not_recomputed", "warn"], ["unchecked", "warn"], ["information", ""]];

export function certificateList(run) {
  const base = `runs/${encodeURIComponent(run)}`;
  const list = h("div", { class: "stack" });
  const status = h("div", { class: "told", role: "status" });
  const places = new Map(); // the messages about each certificate, by number: they stay when the list is read again
  const verifyRun = button(t("certificates.verify_run"), () => verify(`${base}/verify`, status));
  load();

  async function load() {
    const answer = await get(`${base}/certificates`).catch(() => ({ items: [], can_sign: false }));
    fill(list, answer.items.length ? answer.items.map((item) => row(item, answer.can_sign)) : h("p", { class: "soft" }, t("certificates.none")));
  }

  function row(item, canSign) {
    if (!places.has(item.number)) places.set(item.number, h("div", { class: "told", role: "status" }));
    const place = places.get(item.number);
    const address = `${base}/certificates/${encodeURIComponent(item.number)}`;
    const marks = [
      item.for_certification ? null : h("span", { class: "mark warn" }, t("certificates.not_for")),
      item.withdrawn ? h("span", { class: "mark warn" }, t("certificates.withdrawn")) : null,
      item.replaced_by ? h("span", { class: "mark warn" }, t("certificates.replaced", { number: item.replaced_by })) : null,
      item.signed ? h("span", { class: "mark pass" }, t("certificates.signed")) : null,
    ];
    return h("div", { class: "issued" },
      h("div", { class: "row" }, h("strong", {}, item.number), marks),
      h("p", { class: "soft" }, t("certificates.by", { time: localTime(item.issued_utc), name: item.by })),
      item.withdrawn ? h("p", { class: "soft" }, translate(item.withdrawn)) : null,
      item.amends ? h("p", { class: "soft" }, t("certificates.amends", { number: item.amends, reason: item.reason })) : null,
      fileList(item.files),
      h("div", { class: "row" },
        button(t("certificates.verify"), () => verify(`${address}/verify`, place)),
        item.replaced_by ? null : button(t("certificates.amend"), () => amend(item, address)),
        item.replaced_by || item.withdrawn ? null : button(t("certificates.withdraw"), () => withdraw(item, address)),
        canSign && !item.signed && !item.withdrawn ? button(t("certificates.sign"), () => sign(item, address)) : null),
      place);
  }

  async function verify(path, place) {
    try {
      const verification = await working(place, t("certificates.verifying"), () => post(path));
      fill(place, h("p", { class: verification.matches ? "good-text" : "bad-text" }, verification.matches ? t("certificates.match") : verification.conclusion.split("; ").map(translate).join("; ")),
        FINDINGS.map(([key, kind]) => verification[key].map((text) => h("p", { class: kind ? `${kind}-text` : "soft" }, translate(text)))).flat(),
        h("details", {}, h("summary", {}, t("certificates.held", { count: verification.held.length })), h("ul", {}, verification.held.map((text) => h("li", {}, translate(text))))));
    } catch (error) {
      fill(place, refusal(error));
    }
  }

  // Shows a form and does the change; a refusal is shown in the form, which stays open.
  async function change({ title, confirm, what, path, fields, required, body, words, by }) {
    const doing = h("div", { class: "told", role: "status" });
    let answer = null;
    await askForm(title, [...Object.values(fields).map((item) => item.element), doing], {
      confirm,
      read: () => true,
      check: async () => {
        fill(doing);
        if (!filledIn(required)) return false;
        try {
          answer = (await takeControl(by.value())) ? await working(doing, what, () => post(path, body())) : null;
        } catch (error) {
          refuse(error, fields, doing);
        }
        return answer !== null;
      },
    });
    if (!answer) return;
    await load();
    fill(status, words(answer));
  }

  async function amend(item, address) {
    const reason = textField("amend-reason", t("certificates.reason"), { required: true });
    const by = textField("amend-by", t("certificate.by"), { value: personName(), required: true });
    const order = Object.fromEntries(CHANGES.map((name) => [name, textField(`amend-${name}`, t(`certificate.${name}`), { type: name === "received" ? "date" : "text" })]));
    const hint = { element: h("p", { class: "soft" }, t("certificates.amend_hint")) };
    await change({
      title: t("certificates.amend_title", { number: item.number }), confirm: t("certificates.amend"), what: t("certificate.issuing"), path: `${address}/amend`,
      fields: { hint, reason, authorised_by: by, ...order }, required: [reason, by], by, words: issuedWords,
      body: () => ({ reason: reason.value(), authorised_by: by.value(), order: Object.fromEntries(Object.entries(order).map(([name, control]) => [name, control.value()]).filter(([, value]) => value)) }),
    });
  }

  async function withdraw(item, address) {
    const reason = textField("withdraw-reason", t("certificates.reason"), { required: true });
    const by = textField("withdraw-by", t("certificates.who_withdraws"), { value: personName(), required: true });
    const hint = { element: h("p", { class: "soft" }, t("certificates.withdraw_hint")) };
    await change({
      title: t("certificates.withdraw_title", { number: item.number }), confirm: t("certificates.withdraw"), what: t("certificates.withdraw"), path: `${address}/withdraw`,
      fields: { hint, reason, by }, required: [reason, by], by,
      words: (answer) => [h("p", {}, t("certificates.inform", { number: item.number })), fileList(answer.files)],
      body: () => ({ reason: reason.value(), by: by.value() }),
    });
  }

  async function sign(item, address) {
    const by = textField("sign-by", t("certificates.who"), { value: personName(), required: true });
    const passphrase = textField("sign-passphrase", t("certificates.passphrase"), { type: "password" });
    await change({
      title: t("certificates.sign_title", { number: item.number }), confirm: t("certificates.sign"), what: t("certificates.signing"), path: `${address}/sign`,
      fields: { by, passphrase }, required: [by], by, words: () => [h("p", { class: "good-text" }, `${item.number}: ${t("certificates.signed")}`)],
      body: () => ({ by: by.value(), passphrase: passphrase.control.value }),
    });
  }

  return { element: h("section", { class: "card" }, h("h2", {}, t("certificates.title")), list, h("div", { class: "row" }, verifyRun), status), load };
}
