// The preflight: its checks, each with the way to fix it, and those that may be overridden.

import { personName } from "../client.js";
import { isBusy } from "./bar.js";
import { askReason } from "./dialogs.js";
import { button, fill, h, setText, show } from "../dom.js";
import { steer } from "../steer.js";
import { store } from "../store.js";
import { translate, t } from "../texts.js";

const SIGNS = { ok: "✓", warn: "!", fail: "✗" };
const GRAVEST = ["fail", "warn", "ok"];

// Some names only say the kind again: "disk"; that of a partner run says all of it.
function title({ kind, name }) {
  if (kind === "partner") return translate(name);
  const same = name.replaceAll(/[ -]/g, "_").startsWith(kind);
  return [t(`preflight.kind.${kind}`), same ? "" : name].filter(Boolean).join(" ");
}

export function preflightCard({ procedure, station }) {
  const passed = new Set();
  const items = h("ul", { class: "lights", tabindex: "0", "aria-label": t("preflight.title") });
  const note = h("p", { class: "soft", role: "status" });
  let outdated = false; // earlier results do not count once a new preflight is requested
  const check = button(t("preflight.check"), lookAgain, { kind: "big" });
  const by = h("input", { type: "text", id: "override-by", value: personName(), autocomplete: "off", oninput: () => card.onchange() });
  const reason = h("input", { type: "text", id: "override-reason", autocomplete: "off", oninput: () => card.onchange() });
  const override = h("div", { class: "override", hidden: true },
    h("h3", {}, t("preflight.override")),
    h("div", { class: "field" }, h("label", { for: "override-by" }, t("preflight.by")), by),
    h("div", { class: "field" }, h("label", { for: "override-reason" }, t("preflight.reason")), reason));

  async function lookAgain() {
    outdated = true;
    card.onchange();
    if (!(await steer("preflight", { procedure, station }))) outdated = false; // refused
    card.onchange();
  }

  function mine() {
    const preflight = store.state?.preflight;
    return preflight && preflight.procedure === procedure && preflight.station === station ? preflight : null;
  }

  function fails() {
    return (mine()?.items ?? []).filter((item) => item.state === "fail");
  }

  const card = {
    element: h("section", { class: "card preflight" },
      h("div", { class: "preflight-list" }, h("h2", {}, t("preflight.title")), note, items), override, check),
    onchange: () => {},
    done: () => Boolean(mine()?.done),
    may: () => !outdated && Boolean(mine()?.done) && fails().every((item) => item.override && passed.has(item.override)) && (!passed.size || Boolean(by.value.trim() && reason.value.trim())),
    override: () => (passed.size ? { what: [...passed], by: by.value.trim(), reason: reason.value.trim() } : null),
    update,
  };

  function update() {
    const preflight = mine();
    const checking = store.state?.phase === "checking";
    if (checking) outdated = false;
    check.disabled = isBusy(store.state);
    setText(check.firstChild, checking ? t("preflight.checking") : preflight?.done ? t("preflight.again") : t("preflight.check"));
    for (const name of [...passed]) if (!fails().some((item) => item.override === name)) passed.delete(name);
    const ordered = (preflight?.items ?? []).toSorted((a, b) => GRAVEST.indexOf(a.state) - GRAVEST.indexOf(b.state));
    fill(items, ordered.map(light));
    setText(note, !preflight ? t("preflight.not_yet") : !preflight.done ? t("preflight.checking") : preflight.may_start ? t("preflight.green") : t("preflight.red", { count: fails().length, of: preflight.items.length }));
    show(override, passed.size > 0);
    if (!by.value) by.value = personName(); // the name was entered to take control meanwhile
    card.onchange();
  }

  // A rig that was left energised and cannot be read back: a person looks at it, and says so by name.
  async function sayItIsSafe() {
    const safe = await askReason(t("preflight.safe.title"), { confirm: t("preflight.safe.confirm") });
    if (safe) await steer("preflight", { procedure, station, safe });
  }

  function light(item) {
    const pass = item.state === "fail" && item.override ? h("label", { class: "check" }, h("input", { type: "checkbox", checked: passed.has(item.override), onchange: (event) => {
      if (event.target.checked) passed.add(item.override);
      else passed.delete(item.override);
      show(override, passed.size > 0);
      event.target.closest("label").scrollIntoView({ block: "nearest" }); // not below the fields that have come
      card.onchange();
    } }), h("span", {}, t("preflight.let_pass"))) : null;
    const safe = item.asks_safe ? button(t("preflight.safe"), sayItIsSafe) : null;
    return h("li", { class: `light ${item.state}` },
      h("span", { class: "sign", role: "img", "aria-label": t(`preflight.${item.state}`) }, SIGNS[item.state]),
      h("div", { class: "light-text" }, h("strong", {}, title(item)), h("span", {}, translate(item.text)), item.fix ? h("span", { class: "fix" }, translate(item.fix)) : null, pass, safe));
  }

  return card;
}
