// The large numbers: what is set, what is measured, and what comes out.

import { fill, h, setText } from "../dom.js";
import { clock, fixed, plain, UNKNOWN, withUncertainty } from "../format.js";
import { isOld } from "./channels.js";
import { store } from "../store.js";
import { said, t } from "../texts.js";

function readout(name, kind = "") {
  const value = h("span", { class: "readout-value" }, UNKNOWN);
  const small = h("span", { class: "readout-small" });
  return { element: h("div", { class: `readout ${kind}` }, h("span", { class: "readout-name" }, name), value, small), value, small };
}

// What is old looks old, and says since when.
function age(row, text, utc) {
  const old = Boolean(utc) && isOld(utc);
  row.element.classList.toggle("old", old);
  setText(row.small, [text, old ? t("read.since", { time: clock(utc) }) : ""].filter(Boolean).join(" · "));
}

// The point that is being recorded, or the last one that was analysed.
export function presentPoint(state) {
  const points = state.live?.points ?? [];
  const name = state.progress?.recording;
  return points.find((point) => point.recording === name) ?? points.at(-1) ?? null;
}

// Whether a cycle with a frequency is what the run is about; a plan that is not there yet may be.
export function hasSwing(state) {
  if (state.job?.kind === "manual" || !state.plan) return true;
  return state.plan.steps.some((step) => Number.isFinite(step.frequency_hz)) || Boolean(state.live?.points.length);
}

const MOST_VALUES = 5;

// The latest values by name, in the units in which they are written.
function valueText({ shown, shown_in: unit }) {
  return unit && unit !== "1" ? `${plain(shown)} ${unit}` : plain(shown);
}

export function readouts() {
  const frequency = readout(t("read.frequency"));
  const load = readout(t("read.load"));
  const raw = readout(t("read.raw"), "raw");
  const rig = readout(t("read.compensation"));
  const torque = readout(t("read.torque"), "compensated");
  const rows = [frequency, load, raw, rig, torque];
  const element = h("div", { class: "readouts" }, rows.map((row) => row.element));
  let named = "";
  let shown = [];

  function showValues(values) {
    const latest = Object.entries(values).slice(-MOST_VALUES);
    const names = latest.map(([name]) => name).join();
    if (names !== named) {
      named = names;
      shown = latest.map(([name]) => readout(name));
      element.classList.add("of-values");
      fill(element, shown.map((row) => row.element));
    }
    latest.forEach(([, value], i) => {
      setText(shown[i].value, valueText(value));
      age(shown[i], "", value.utc);
    });
  }

  return {
    element,
    update() {
      const { state } = store;
      if (!hasSwing(state)) {
        showValues(state.readings.values);
        return;
      }
      if (named) {
        named = "";
        element.classList.remove("of-values");
        fill(element, rows.map((row) => row.element));
      }
      const { readings } = state;
      const point = presentPoint(state);
      const unit = (number, decimals, symbol) => (Number.isFinite(number) ? `${fixed(number, decimals)} ${symbol}` : UNKNOWN);
      const isNow = point && (state.job?.kind === "manual" || point.recording === state.progress?.recording);
      const here = isNow ? point : null; // what was recorded before may no longer be so
      const turning = state.pause ? null : readings.frequency_hz ?? here?.frequency_hz; // what is paused was measured before
      setText(frequency.value, unit(turning, 2, "Hz"));
      age(frequency, t("read.set", { value: unit(readings.set_frequency_hz, 2, "Hz") }), state.pause ? "" : readings.frequency_utc);
      setText(load.value, unit(readings.load_n ?? here?.load_n, 0, "N"));
      age(load, t("read.set", { value: unit(readings.set_load_n, 0, "N") }), readings.load_utc);
      for (const row of [raw, rig, torque]) row.element.classList.toggle("old", Boolean(point) && !isNow);
      setText(raw.value, unit(point?.raw_nm, 3, "N·m"));
      setText(raw.small, point ? t("read.cycles", { cycles: point.cycles, value: `${plain(point.set_frequency_hz)} Hz` }) : "");
      setText(rig.value, unit(point?.rig_nm, 3, "N·m"));
      setText(rig.small, state.live?.method ?? "");
      setText(torque.value, point && Number.isFinite(point.torque_nm) ? withUncertainty(point.torque_nm, point.U_nm, "N·m") : UNKNOWN);
      setText(torque.small, point && Number.isFinite(point.torque_nm) ? t("read.at", { value: `${plain(point.set_frequency_hz)} Hz` }) : said(state.live?.problem ?? ""));
      torque.small.title = torque.small.textContent; // two lines of it are seen
    },
  };
}
