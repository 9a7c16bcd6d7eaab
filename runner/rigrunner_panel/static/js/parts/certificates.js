// The certificates of a run: verified, amended and signed; and the run itself verified.

import { get, personName, post } from "../client.js";
import { button, fill, h } from "../dom.js";
import { localTime } from "../format.js";
import { takeControl } from "../steer.js";
import { t } from "../texts.js";
import { issuedWords, refusal } from "./certificate.js";
import { askForm } from "./dialogs.js";
import { working } from "./working.js";

const CHANGES = ["customer", "customer_contact", "item", "item_id", "item_condition", "received", "operator"];
const FINDINGS = [["differences", "bad"], ["replaced", "warn"], ["unproven", "warn"], ["not_recomputed", "warn"], ["unchecked", "warn"], ["information", ""]];

export function certificateList(run) {
  const base = `runs/${encodeURIComponent(run)}`;
  const list = h("div", { class: "stack" });
  const told = h("div", { class: "told", role: "status" });
  const whole = button(t("certificates.verify_run"), () => verify(`${base}/verify`, told));
  load();

  async function load() {
    const found = await get(`${base}/certificates`).catch(() => ({ items: [], can_sign: false }));
    fill(list, found.items.length ? found.items.map((each) => row(each, found.can_sign)) : h("p", { class: "soft" }, t("certificates.none")));
  }

  function row(item, canSign) {
    const place = h("div", { class: "told", role: "status" });
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
        item.replaced_by ? null : button(t("certificates.amend"), () => amend(item, one, place)),
        canSign && !item.signed ? button(t("certificates.sign"), () => sign(item, one, place)) : null),
      place);
  }

  async function verify(path, place) {
    try {
      const found = await working(place, t("certificates.verifying"), () => post(path));
      fill(place, h("p", { class: found.matches ? "good-text" : "bad-text" }, found.matches ? t("certificates.match") : found.conclusion),
        FINDINGS.map(([key, kind]) => found[key].map((text) => h("p", { class: kind ? `${kind}-text` : "soft" }, text))).flat(),
        h("details", {}, h("summary", {}, t("certificates.held", { count: found.held.length })), h("ul", {}, found.held.map((text) => h("li", {}, text)))));
    } catch (error) {
      fill(place, refusal(error));
    }
  }

  // Does something that needs control, and lists the certificates anew.
  async function change(place, what, path, body, words) {
    try {
      if (!(await takeControl())) return;
      const made = await working(place, what, () => post(path, body));
      await load();
      fill(told, words(made));
    } catch (error) {
      fill(place, refusal(error));
    }
  }

  async function amend(item, one, place) {
    const reason = field("amend-reason", t("certificates.reason"), { required: true });
    const by = field("amend-by", t("certificate.by"), { value: personName(), required: true });
    const order = CHANGES.map((name) => [name, field(`amend-${name}`, t(`certificate.${name}`), { type: name === "received" ? "date" : "text" })]);
    const rows = [h("p", { class: "soft" }, t("certificates.amend_hint")), reason.row, by.row, ...order.map(([, each]) => each.row)];
    const given = await askForm(t("certificates.amend_title", { number: item.number }), rows, {
      confirm: t("certificates.amend"),
      check: () => reason.value() && by.value(),
      read: () => ({ reason: reason.value(), authorised_by: by.value(), order: Object.fromEntries(order.map(([name, each]) => [name, each.value()]).filter(([, value]) => value)) }),
    });
    if (given) await change(place, t("certificate.issuing"), `${one}/amend`, given, issuedWords);
  }

  async function sign(item, one, place) {
    const by = field("sign-by", t("certificates.who"), { value: personName(), required: true });
    const passphrase = field("sign-passphrase", t("certificates.passphrase"), { type: "password" });
    const given = await askForm(t("certificates.sign_title", { number: item.number }), [by.row, passphrase.row], {
      confirm: t("certificates.sign"),
      check: () => by.value(),
      read: () => ({ by: by.value(), passphrase: passphrase.value() }),
    });
    if (given) await change(place, t("certificates.signing"), `${one}/sign`, given, () => [h("p", { class: "good-text" }, `${item.number}: ${t("certificates.signed")}`)]);
  }

  return { element: h("section", { class: "card" }, h("h2", {}, t("certificates.title")), list, h("div", { class: "row" }, whole), told), load };
}

function field(id, label, { type = "text", value = "", required = false } = {}) {
  const input = h("input", { type, id, value, required, autocomplete: "off" });
  return { row: h("div", { class: "field" }, h("label", { for: id }, label), input), value: () => (type === "password" ? input.value : input.value.trim()) };
}
