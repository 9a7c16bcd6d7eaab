// The stored runs: searched, filtered, and two of them compared.

import { go } from "../address.js";
import { get } from "../client.js";
import { afterTyping, button, fill, h, setText, show } from "../dom.js";
import { localTime, shownNumber, withUncertainty } from "../format.js";
import { field } from "../parts/field.js";
import { verdictText } from "../parts/verdict.js";
import { working } from "../parts/working.js";
import { attempt } from "../steer.js";
import { translate, t } from "../texts.js";

const TYPING_MS = 200;
const MOST_OVERLAID = 6;
const PAGE = 50;

export function historyPage() {
  const chosen = []; // names of runs, which begin with their time: sorted, the older one comes first
  const later = afterTyping(() => load(false), TYPING_MS);
  const filters = {
    search: h("input", { type: "search", id: "history-search", autocomplete: "off", oninput: later }),
    verdict: choice("history-verdict", "verdict.any", ["pass", "conditional pass", "inconclusive", "conditional fail", "fail"], verdictText),
    outcome: choice("history-outcome", "outcome.any", ["completed", "stopped at a limit", "aborted", "error"], (name) => t(`outcome.${name}`)),
  };
  const rows = h("tbody", {});
  const doing = h("div", { role: "status" });
  const nothing = h("p", { class: "nothing", hidden: true }, t("history.nothing"));
  const more = button(t("history.more"), () => load(true), { kind: "big" });
  const compare = button(t("history.compare"), () => go(`#/compare/${[...chosen].sort().map(encodeURIComponent).join("/")}`), { kind: "primary" });
  const overlay = button(t("history.overlay"), () => go(`#/overlay/${chosen.map(encodeURIComponent).join("/")}`));
  let last = "";
  let requests = 0;

  function choice(id, any, names, words) {
    return h("select", { id, onchange: () => load(false) }, h("option", { value: "" }, t(any)), names.map((name) => h("option", { value: name }, words(name))));
  }

  async function load(onwards) {
    const request = ++requests;
    const query = { search: filters.search.value.trim(), verdict: filters.verdict.value, outcome: filters.outcome.value, limit: PAGE, before: onwards ? last : "" };
    const answer = await working(doing, t("history.reading"), () => attempt(() => get("runs", query)));
    if (!answer || request !== requests) return;
    if (!onwards) fill(rows);
    rows.append(...answer.items.map(row));
    last = answer.items.at(-1)?.run ?? last;
    show(more, answer.more);
    show(nothing, rows.children.length === 0);
  }

  function row(item) {
    const box = h("input", { type: "checkbox", "aria-label": t("history.choose", { run: item.run }), checked: chosen.includes(item.run), onchange: () => {
      const at = chosen.indexOf(item.run);
      if (at >= 0) chosen.splice(at, 1);
      else chosen.push(item.run);
      update();
    } });
    const outcome = item.interrupted ? "unknown" : item.outcome;
    const verdict = item.verdict || (outcome && outcome !== "completed" ? outcome : "");
    const open = (event) => {
      if (!event.target.closest("a, label, input") && !String(getSelection())) go(`#/runs/${encodeURIComponent(item.run)}`);
    };
    return h("tr", { onclick: open },
      h("td", {}, h("label", { class: "tick" }, box)),
      h("td", {}, h("a", { class: "row-link", href: `#/runs/${encodeURIComponent(item.run)}` }, localTime(item.started_utc) || item.run)),
      h("td", { class: "wrap" }, translate(item.title) || item.problem || item.run), h("td", { class: "wrap" }, item.specimen), h("td", {}, item.station),
      h("td", {}, verdict ? h("span", { class: `mark ${item.interrupted ? "interrupted" : verdict.replaceAll(" ", "-")}` }, item.verdict ? verdictText(item.verdict) : t(`outcome.${outcome}`)) : ""),
      h("td", { class: "number" }, item.headline ? withUncertainty(item.headline.value, item.headline.U, item.headline.unit) : shownNumber(item.result ?? "")));
  }

  function update() {
    compare.disabled = chosen.length !== 2;
    overlay.disabled = chosen.length < 2 || chosen.length > MOST_OVERLAID;
    setText(overlay.firstChild, t("history.overlay_n", { count: chosen.length }));
    setText(compare.firstChild, t("history.compare_n", { count: chosen.length }));
  }

  const head = ["history.select", "history.when", "history.what", "history.specimen", "history.station", "history.verdict", "history.value"];
  load(false);
  update();
  return {
    title: t("history.title"),
    element: h("div", { class: "page history" },
      h("div", { class: "head" }, h("h1", {}, t("history.title")), h("div", { class: "row" }, h("a", { class: "button", href: "#/trends" }, t("trends.title")), overlay, compare)),
      h("div", { class: "filters" },
        Object.entries(filters).map(([name, control]) => field(t(`history.${name}`), control).element)),
      doing,
      h("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": t("history.title") }, h("table", { class: "runs" }, h("thead", {}, h("tr", {}, head.map((key) => h("th", { scope: "col" }, t(key))))), rows), nothing, more)),
  };
}
