// Control charts of results: one for each group, with the runs at which a rule is met.

import { get, post } from "../client.js";
import { fill, h } from "../dom.js";
import { localTime, plain } from "../format.js";
import { refusal, refuse } from "../parts/certificate.js";
import { field } from "../parts/field.js";
import { working } from "../parts/working.js";
import { resultCharts } from "../plots/results.js";
import { translate, t } from "../texts.js";

const GROUPS = ["type", "lot", "rig", "mandrel", "specimen", "operator", "procedure", "revision"];

export function trendsPage() {
  const quantity = select("trend-quantity", []);
  const by = select("trend-by", [["", t("trends.by_usual")], ...GROUPS.map((name) => [name, t(`trends.group.${name}`)])]);
  const chart = select("trend-chart", [["i-mr", t("trends.individuals")], ["ewma", t("trends.ewma")]]);
  const baseline = field(t("trends.baseline"), h("input", { type: "text", id: "trend-baseline", value: "20", autocomplete: "off", onchange: load }));
  const status = h("div", { role: "status" });
  const charts = h("div", { class: "stack" });
  let shown = [];
  let requests = 0;

  function select(id, choices) {
    return h("select", { id, onchange: load }, choices.map(([value, text]) => h("option", { value }, text)));
  }

  async function open() {
    try {
      const { items } = await working(status, t("trends.reading"), async () => {
        await post("archive/update");
        return get("archive/quantities");
      });
      fill(quantity, items.map((name) => h("option", { value: name }, name.split("/").map(translate).join("/"))));
      if (items.length) load();
      else fill(status, h("p", { class: "nothing" }, t("trends.nothing")));
    } catch (error) {
      fill(status, refusal(error));
    }
  }

  async function load() {
    if (!quantity.value) return;
    const request = ++requests;
    clear();
    try {
      const query = { quantity: quantity.value, by: by.value, chart: chart.value, baseline: baseline.value() };
      const study = await working(status, t("trends.charting"), () => get("trend", query));
      if (request !== requests) return; // a newer request was made meanwhile
      clear();
      fill(charts, study.charts.map((item) => group(item, study)));
      fill(status, study.charts.length ? null : h("p", { class: "nothing" }, t("trends.no_chart")), study.warnings.map((text) => h("p", { class: "banner warn" }, translate(text))), leftOut(study));
    } catch (error) {
      if (request === requests) refuse(error, { baseline }, status);
    }
  }

  function clear() {
    for (const plot of shown) plot.leave();
    shown = [];
    fill(charts);
  }

  function group(item, study) {
    const plot = resultCharts(1);
    shown.push(plot);
    const series = item.figure.series.map((line) => ({ ...line, name: line.kind === "marked" ? t("trends.alarm") : translate(line.name) }));
    plot.show([{ ...item.figure, series, title: translate(item.figure.title), x: { ...item.figure.x, name: t("trends.run") }, y: { ...item.figure.y, name: translate(item.figure.y.name) } }]);
    const numbers = [["trends.centre", item.centre], ["trends.lower", item.lower], ["trends.upper", item.upper]];
    return h("section", { class: "card trend-card" }, h("h2", {}, translate(item.name)),
      h("p", {}, numbers.map(([key, value]) => `${t(key)} ${plain(value)} ${study.unit}`).join(" · ")),
      plot.element,
      item.alarms.length
        ? h("ul", { class: "changes" }, item.alarms.map((alarm) => h("li", {}, h("span", { class: "mark bad" }, `${plain(alarm.value)} ${study.unit}`),
          h("span", {}, h("a", { href: `#/runs/${encodeURIComponent(alarm.run)}` }, `${localTime(alarm.utc)} ${alarm.run}`), h("span", { class: "soft block" }, alarm.rules.map((rule) => translate(study.rules[rule] ?? rule)).join("; "))))))
        : h("p", { class: "good-text" }, t("trends.no_alarm")),
      item.warnings.map((text) => h("p", { class: "soft" }, translate(text))));
  }

  // Groups and runs that are in no chart, and why.
  function leftOut(study) {
    const rows = [...Object.entries(study.not_charted).map(([name, reason]) => `${translate(name)}: ${translate(reason)}`), ...study.excluded.map((run) => `${run.run}: ${translate(run.reason)}`)];
    return rows.length ? h("details", { open: !study.charts.length }, h("summary", {}, t("trends.left_out", { count: rows.length })), h("ul", {}, rows.map((text) => h("li", {}, text)))) : null;
  }

  open();
  return {
    title: t("trends.title"),
    element: h("div", { class: "page trends" }, h("div", { class: "head" }, h("h1", {}, t("trends.title")), h("a", { class: "button", href: "#/history" }, t("nav.history"))),
      h("div", { class: "filters four" }, field(t("trends.quantity"), quantity).element, field(t("trends.by"), by).element, field(t("trends.chart"), chart).element, baseline.element),
      status, charts),
    leave: clear,
  };
}
