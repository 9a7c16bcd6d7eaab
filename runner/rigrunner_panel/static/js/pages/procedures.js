// The procedures in the lab's folder, and those that are shipped.

import { go } from "../address.js";
import { get } from "../client.js";
import { afterTyping, breakable, fill, h, show } from "../dom.js";
import { localTime } from "../format.js";
import { working } from "../parts/working.js";
import { attempt } from "../steer.js";
import { translate, t } from "../texts.js";

const TYPING_MS = 150;

export function proceduresPage() {
  const later = afterTyping(load, TYPING_MS);
  const rows = h("tbody");
  const doing = h("div", { role: "status" });
  const nothing = h("p", { class: "nothing", hidden: true }, t("choose.nothing"));
  const search = h("input", { type: "search", id: "search-procedures", autocomplete: "off", oninput: later });
  let requests = 0;

  async function load() {
    const request = ++requests;
    const answer = await working(doing, t("loading"), () => attempt(() => get("procedures", { search: search.value.trim() })));
    if (!answer || request !== requests) return;
    fill(rows, answer.items.map(row));
    show(nothing, answer.items.length === 0);
  }

  load();
  const head = ["procedures.name", "procedures.file", "procedures.state", "procedures.used"];
  return {
    title: t("nav.procedures"),
    element: h("div", { class: "page procedures" },
      h("div", { class: "head" }, h("h1", {}, t("nav.procedures"))),
      h("div", { class: "field" }, h("label", { for: "search-procedures" }, t("choose.search_procedure")), search),
      doing,
      h("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": t("nav.procedures") },
        h("table", { class: "runs" }, h("thead", {}, h("tr", {}, head.map((key) => h("th", { scope: "col" }, t(key))))), rows), nothing)),
  };
}

function row(item) {
  const address = `#/procedures/${encodeURIComponent(item.name)}`;
  const open = (event) => {
    if (!event.target.closest("a") && !String(getSelection())) go(address);
  };
  return h("tr", { onclick: open },
    h("td", {}, h("a", { class: "row-link wide", href: address }, translate(item.title) || item.name), item.problem ? h("span", { class: "bad-text block" }, translate(item.problem)) : null),
    h("td", { class: "wrap" }, item.shipped ? t("choose.shipped") : breakable(item.name)),
    h("td", {}, item.problem ? h("span", { class: "mark bad" }, t("choose.broken")) : translate(item.note)),
    h("td", {}, item.last_used_utc ? localTime(item.last_used_utc) : ""));
}
