// The large numbers: what is set, what is measured, and what comes out.

import { fill, h, setText } from "../dom.js";
import { clock, plain, shownNumber, UNKNOWN, withUncertainty } from "../format.js";
import { ageText, isOld } from "./channels.js";
import { store } from "../store.js";
import { translate, t } from "../texts.js";

function readout(name, kind = "") {
  const value = h("span", { class: "readout-value" }, UNKNOWN);
  const small = h("span", { class: "readout-small" });
  return { element: h("div", { class: `readout ${kind}` }, h("span", { class: "readout-name" }, name), value, small), value, small };
}

// How old it is; what is old looks old, and says since when.
function age(row, text, utc) {
  const old = Boolean(utc) && isOld(utc);
  row.element.classList.toggle("old", old);
  const since = old ? t("read.since", { time: clock(utc) }) : utc ? ageText(utc) : "";
  setText(row.small, [text, since].filter(Boolean).join(" · "));
}

// The value that the analyses show of the readings in progress, or the last one that they showed; null where they cannot.
function presentResult({ live }) {
  const results = live?.results ?? [];
  return results.findLast((result) => result.is_ongoing) ?? (live?.problem ? null : results.at(-1));
}

// Where drives were set and what was read, the drives first.
function presentValues({ readings, channels, plan }, most) {
  const drives = plan?.drives ?? {};
  const names = new Map([...Object.entries(drives), ...channels.map((channel) => [channel.name, channel.long_name])]);
  const all = Object.entries(readings);
  const isDrive = ([name]) => name in drives;
  const shown = [...all.filter(isDrive), ...all.filter((entry) => !isDrive(entry)).reverse()].slice(0, most);
  return shown.map(([name, value]) => ({ key: name, name: translate(names.get(name)) || name, value }));
}

const MOST_VALUES = 5;
const MOST_BESIDE_RESULT = 3;

// A value in the unit in which it is written.
function valueText(shown, { shown_in: unit }) {
  const number = plain(Number(shown.toPrecision(5)));
  return unit && unit !== "1" ? `${number} ${unit}` : number;
}

function resultText({ value, U, unit }) {
  return withUncertainty(value, U ?? NaN, unit === "1" ? "" : unit);
}

export function readouts() {
  const element = h("div", { class: "readouts" });
  let rows = new Map();
  let built = "";

  // Each row is [key, name, kind]; a row that stays keeps its place on the page.
  function build(rowSpecs) {
    const key = JSON.stringify(rowSpecs);
    if (key === built) return;
    built = key;
    rows = new Map(rowSpecs.map(([id, name, kind]) => [id, readout(name, kind)]));
    fill(element, [...rows.values()].map((row) => row.element));
  }

  return {
    element,
    update() {
      const { state } = store;
      const result = presentResult(state);
      const problem = result ? "" : state.live?.problem;
      const values = presentValues(state, result || problem ? MOST_BESIDE_RESULT : MOST_VALUES);
      const corrects = Number.isFinite(result?.uncorrected);
      build([...values.map(({ key, name }) => [key, name, ""]),
        ...(corrects ? [["uncorrected", t("read.uncorrected"), "raw"]] : []),
        ...(result ? [["result", translate(result.text) || result.name, "compensated"]] : []),
        ...(problem ? [["problem", t("read.result"), "compensated"]] : [])]);
      for (const { key, value } of values) {
        const row = rows.get(key);
        setText(row.value, valueText(value.shown, value));
        age(row, Number.isFinite(value.set) ? t("read.set", { value: valueText(value.set, value) }) : "", value.utc);
      }
      if (problem) {
        const { small } = rows.get("problem");
        setText(small, shownNumber(translate(problem)));
        small.title = small.textContent; // two lines of it are seen
      }
      if (!result) return;
      const row = rows.get("result");
      setText(row.value, resultText(result));
      const place = [shownNumber(result.place).replaceAll("-", "\u2212"), result.readings === 1 ? t("read.reading") : t("read.readings", { count: result.readings })].filter(Boolean).join(" · ");
      setText(row.small, place);
      if (corrects) {
        const { value, small } = rows.get("uncorrected");
        setText(value, resultText({ ...result, value: result.uncorrected, U: null }));
        setText(small, place);
      }
      for (const name of ["result", "uncorrected"]) rows.get(name)?.element.classList.toggle("old", !result.is_ongoing || state.phase === "finished");
    },
  };
}
