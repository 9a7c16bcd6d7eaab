// Choose a procedure and a station: what was used last comes first.

import { goToRig, station } from "../address.js";
import { get } from "../client.js";
import { afterTyping, button, fill, h } from "../dom.js";
import { draft, newDraft } from "../draft.js";
import { localTime } from "../format.js";
import { isBusy } from "../parts/bar.js";
import { working } from "../parts/working.js";
import { attempt } from "../steer.js";
import { listen, store } from "../store.js";
import { translate, t } from "../texts.js";

const TYPING_MS = 150;

export function choosePage() {
  const chosen = { procedure: draft().procedure ?? "", station: station() };
  const next = button(t("choose.next"), proceed, { kind: "primary big" });
  const busy = h("p", { class: "banner info", hidden: true });
  const procedures = list("procedures", "procedure", chosen, update);
  const stations = list("stations", "station", chosen, update);

  function update() {
    next.disabled = !(chosen.procedure && chosen.station);
  }

  function proceed() {
    const before = draft(chosen.station);
    const same = before.procedure === chosen.procedure;
    newDraft({ ...before, ...chosen, inputs: same ? before.inputs : {}, entry: 0 });
    goToRig(chosen.station, "#/setup");
  }

  function showBusy() {
    const running = isBusy(store.state) && store.state.job;
    busy.hidden = !running;
    if (!running) return;
    const kind = store.state.job.kind === "manual" ? "#/manual" : "#/run";
    fill(busy, h("span", {}, t("choose.busy", { title: translate(store.state.job.title) })), h("a", { class: "button", href: kind }, t("choose.watch")));
  }

  const forget = listen((changed) => {
    if (changed.has("phase") || changed.has("job")) showBusy();
  });
  update();
  showBusy();
  return {
    title: t("choose.title"),
    element: h("div", { class: "page choose" },
      h("h1", {}, t("choose.title")),
      busy,
      h("div", { class: "two" }, procedures, stations),
      h("div", { class: "actions" }, next)),
    leave: forget,
  };
}

function list(path, kind, chosen, changed) {
  const later = afterTyping(load, TYPING_MS);
  const search = h("input", { type: "search", id: `search-${kind}`, autocomplete: "off", placeholder: t(`choose.search_${kind}`), oninput: later });
  const doing = h("div", { role: "status" });
  const items = h("div", { class: "items", role: "radiogroup", "aria-label": t(`choose.${kind}`) });
  let requests = 0;

  async function load() {
    const request = ++requests;
    const answer = await working(doing, t("loading"), () => attempt(() => get(path, { search: search.value.trim() })));
    if (!answer || request !== requests) return;
    const names = answer.items.map((item) => item.name);
    if (!chosen[kind] && answer.items.length) chosen[kind] = answer.items.find((item) => !item.problem)?.name ?? "";
    const focused = items.contains(document.activeElement) ? document.activeElement.id : "";
    fill(items, names.length ? answer.items.map(item) : h("p", { class: "nothing" }, t("choose.nothing")));
    if (focused) document.getElementById(focused)?.focus();
    changed();
  }

  function item(entry) {
    const id = `${kind}-${entry.name}`;
    const input = h("input", { type: "radio", name: kind, id, value: entry.name, checked: entry.name === chosen[kind], disabled: Boolean(entry.problem),
      onchange: () => {
        chosen[kind] = entry.name;
        changed();
      } });
    const facts = [entry.id, entry.shipped ? t("choose.shipped") : "", translate(entry.note)].filter(Boolean).join(" · ");
    const used = entry.last_used_utc ? [facts ? " · " : "", h("span", { class: "whole" }, t("choose.used", { time: localTime(entry.last_used_utc) }))] : null;
    const marks = [entry.problem ? h("span", { class: "mark bad" }, t("choose.broken")) : null];
    return h("label", { class: "item", for: id }, input,
      h("span", { class: "item-text" }, h("strong", {}, translate(entry.title) || entry.name), h("span", { class: "soft" }, facts, used),
        entry.problem ? h("span", { class: "bad-text" }, translate(entry.problem)) : null),
      h("span", { class: "marks" }, marks));
  }

  load();
  return h("section", { class: "card" },
    h("h2", {}, t(`choose.${kind}`)),
    h("label", { class: "visually-hidden", for: `search-${kind}` }, t(`choose.search_${kind}`)),
    search, doing, items);
}
