// Control charts of what the runs found: one for each group, with the runs at which a rule is met.

import { get, post } from "../client.js";
import { fill, h } from "../dom.js";
import { localTime, plain } from "../format.js";
import { refusal, refuse } from "../parts/certificate.js";
import { field } from "../parts/field.js";
import { working } from "../parts/working.js";
import { resultCharts } from "../plots/results.js";
import { said, t } from "../texts.js";

const GROUPS = ["type", "lot", "rig", "mandrel", "specimen", "operator", "procedure", "revision"];

export function trendsPage() {
  const quantity = select("trend-quantity", []);
  const by = select("trend-by", [["", t("trends.by_usual")], ...GROUPS.map((name) => [name, t(`trends.group.${name}`)])]);
  const chart = select("trend-chart", [["i-mr", t("trends.individuals")], ["ewma", t("trends.ewma")]]);
  const baseline = field(t("trends.baseline"), h("input", { type: "text", id: "trend-baseline", value: "20", autocomplete: "off", onchange: load }));
  const told = h("div", { role: "status" });
  const charts = h("div", { class: "stack" });
  let shown = [];
  let asked = 0;

  function select(id, choices) {
    return h("select", { id, onchange: load }, choices.map(([value, text]) => h("option", { value }, text)));
  }

  async function open() {
    try {
      const { items } = await working(told, t("trends.reading"), async () => {
        await post("archive/update");
        return get("archive/quantities");
      });
      fill(quantity, items.map((name) => h("option", { value: name }, name.split("/").map(said).join("/"))));
      if (items.length) load();
      else fill(told, h("p", { class: "nothing" }, t("trends.nothing")));
    } catch (error) {
      fill(told, refusal(error));
    }
  }

  async function load() {
    if (!quantity.value) return;
    const mine = ++asked;
    clear();
    try {
      const query = { quantity: quantity.value, by: by.value, chart: chart.value, baseline: baseline.value() };
      const found = await working(told, t("trends.charting"), () => get("trend", query));
      if (mine !== asked) return; // something else was asked meanwhile
      clear();
      fill(charts, found.charts.map((each) => group(each, found)));
      fill(told, found.charts.length ? null : h("p", { class: "nothing" }, t("trends.no_chart")), found.warnings.map((text) => h("p", { class: "banner warn" }, said(text))), left(found));
    } catch (error) {
      if (mine === asked) refuse(error, { baseline }, told);
    }
  }

  function clear() {
    for (const each of shown) each.leave();
    shown = [];
    fill(charts);
  }

  function group(each, found) {
    const plot = resultCharts(1);
    shown.push(plot);
    const series = each.figure.series.map((one) => ({ ...one, name: one.kind === "marked" ? t("trends.alarm") : said(one.name) }));
    plot.show([{ ...each.figure, series, title: said(each.figure.title), x: { ...each.figure.x, name: t("trends.run") }, y: { ...each.figure.y, name: said(each.figure.y.name) } }]);
    const numbers = [["trends.centre", each.centre], ["trends.lower", each.lower], ["trends.upper", each.upper]];
    return h("section", { class: "card trend-card" }, h("h2", {}, said(each.name)),
      h("p", {}, numbers.map(([key, value]) => `${t(key)} ${plain(value)} ${found.unit}`).join(" · ")),
      plot.element,
      each.alarms.length
        ? h("ul", { class: "changes" }, each.alarms.map((alarm) => h("li", {}, h("span", { class: "mark bad" }, `${plain(alarm.value)} ${found.unit}`),
          h("span", {}, h("a", { href: `#/runs/${encodeURIComponent(alarm.run)}` }, `${localTime(alarm.utc)} ${alarm.run}`), h("span", { class: "soft block" }, alarm.rules.map((rule) => said(found.rules[rule] ?? rule)).join("; "))))))
        : h("p", { class: "good-text" }, t("trends.no_alarm")),
      each.warnings.map((text) => h("p", { class: "soft" }, said(text))));
  }

  // What is in no chart, and why.
  function left(found) {
    const rows = [...Object.entries(found.not_charted).map(([name, reason]) => `${said(name)}: ${said(reason)}`), ...found.excluded.map((each) => `${each.run}: ${said(each.reason)}`)];
    return rows.length ? h("details", { open: !found.charts.length }, h("summary", {}, t("trends.left_out", { count: rows.length })), h("ul", {}, rows.map((text) => h("li", {}, text)))) : null;
  }

  open();
  return {
    title: t("trends.title"),
    element: h("div", { class: "page trends" }, h("div", { class: "head" }, h("h1", {}, t("trends.title")), h("a", { class: "button", href: "#/history" }, t("nav.history"))),
      h("div", { class: "filters four" }, field(t("trends.quantity"), quantity).element, field(t("trends.by"), by).element, field(t("trends.chart"), chart).element, baseline.element),
      told, charts),
    leave: clear,
  };
}
