// Results of any quantity as a table by where they hold, each with its limit.

import { fill, h } from "../dom.js";
import { limitText, shownNumber, withUncertainty } from "../format.js";
import { translate, t } from "../texts.js";
import { SIGNS, verdictText } from "./verdict.js";

// Rows are {name, text, symbol, unit, place, value, U, lower, upper, verdict}.
export function resultTables(rows) {
  const names = [...new Set(rows.map((row) => row.name))];
  return names.map((name) => table(rows.filter((row) => row.name === name)));
}

function table(rows) {
  const [{ text, name, symbol, unit }] = rows;
  const limited = rows.some((row) => limitText(row));
  const placed = rows.some((row) => row.place);
  const cells = (row) => [
    placed ? h("th", { scope: "row" }, shownNumber(row.place).replaceAll("-", "\u2212")) : null,
    h("td", { class: "number" }, withUncertainty(row.value, row.U ?? NaN, "")),
    limited ? [h("td", { class: "number" }, limitText(row)), h("td", { class: "judged" }, judged(row))] : null,
  ].flat();
  const head = [placed ? ["results.where", ""] : null, ["results.value", "number"], limited ? ["results.limit", "number"] : null];
  return h("table", { class: "results" },
    h("caption", {}, [translate(text) || name, symbol, unit && unit !== "1" ? t("results.in_unit", { unit }) : ""].filter(Boolean).join(", ")),
    h("thead", {}, h("tr", {}, head.filter(Boolean).map(([key, kind]) => h("th", { scope: "col", class: kind }, t(key))), limited ? h("td", {}) : null)),
    h("tbody", {}, rows.map((row) => h("tr", {}, cells(row)))));
}

// The verdict counts the uncertainty too; while the run continues there is only whether the value is within.
function judged(row) {
  if (row.verdict) return mark(row.verdict, SIGNS[row.verdict] ?? "~", verdictText(row.verdict));
  if (!limitText(row)) return "";
  const within = !(row.value < row.lower) && !(Number.isFinite(row.upper) && row.value > row.upper);
  return within ? mark("none", "✓", t("results.within")) : mark("fail", SIGNS.fail, t("results.outside"));
}

function mark(verdict, sign, words) {
  return h("span", { class: `mark ${verdict.replaceAll(" ", "-")}`, role: "img", "aria-label": words, title: words }, sign);
}

export function liveResults() {
  const element = h("div", { class: "live-results", role: "region", tabindex: "0", "aria-label": t("results.title") });
  let shown = "";
  return {
    element,
    show(rows) {
      const newest = JSON.stringify(rows);
      if (newest === shown) return;
      shown = newest;
      fill(element, rows.length ? resultTables(rows) : h("p", { class: "soft" }, t("results.none_yet")));
    },
  };
}

// Those of a stored run, from its result document.
export function storedResults(result) {
  const parts = result?.decision?.parts ?? [];
  const partOf = (named) => parts.find((part) => part.named === named.name && part.result?.value === named.estimate.value && part.result.expanded_uncertainty_95 === named.estimate.expanded_uncertainty_95);
  return (result?.results ?? []).map((named) => {
    const part = partOf(named);
    return {
      name: named.name, text: named.text, symbol: named.symbol, unit: named.estimate.unit, place: placeWords(named.coordinates),
      value: named.estimate.value, U: named.estimate.expanded_uncertainty_95, lower: part?.lower_limit?.value, upper: part?.upper_limit?.value, verdict: part?.verdict ?? "",
    };
  });
}

function placeWords(coordinates) {
  return Object.values(coordinates ?? {}).map((value) => (typeof value === "object" ? `${Number(value.value.toPrecision(6))}${value.unit && value.unit !== "1" ? ` ${value.unit}` : ""}` : String(value))).join(", ");
}
