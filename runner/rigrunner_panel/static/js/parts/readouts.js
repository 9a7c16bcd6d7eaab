// The large numbers: what is set, what is measured, and what comes out.

import { fill, h, setText } from "../dom.js";
import { clock, fixed, plain, UNKNOWN, withUncertainty } from "../format.js";
import { ageMs } from "./channels.js";
import { store } from "../store.js";
import { t } from "../texts.js";

function readout(key, kind = "") {
  const value = h("span", { class: "readout-value" }, UNKNOWN);
  const small = h("span", { class: "readout-small" });
  return { element: h("div", { class: `readout ${kind}` }, h("span", { class: "readout-name" }, t(key)), value, small), value, small };
}

function since(text, utc) {
  return utc ? `${text} · ${t("read.since", { time: clock(utc) })}` : text;
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
const OLD_MS = 2000;

// The latest values by name, in the units in which they are written.
function valueText({ shown, shown_in: unit }) {
  return unit && unit !== "1" ? `${plain(shown)} ${unit}` : plain(shown);
}

export function readouts() {
  const frequency = readout("read.frequency");
  const load = readout("read.load");
  const raw = readout("read.raw", "raw");
  const rig = readout("read.compensation");
  const torque = readout("read.torque", "compensated");
  const rows = [frequency, load, raw, rig, torque];
  const element = h("div", { class: "readouts" }, rows.map((row) => row.element));
  let named = "";

  function showValues(values) {
    const latest = Object.entries(values).slice(-MOST_VALUES);
    const newest = JSON.stringify(latest);
    if (newest === named) return;
    named = newest;
    element.classList.add("of-values");
    fill(element, latest.map(([name, value]) => h("div", { class: "readout" }, h("span", { class: "readout-name" }, name), h("span", { class: "readout-value" }, valueText(value)))));
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
      setText(frequency.small, since(t("read.set", { value: unit(readings.set_frequency_hz, 2, "Hz") }), state.pause ? "" : readings.frequency_utc));
      setText(load.value, unit(readings.load_n ?? here?.load_n, 0, "N"));
      load.element.classList.toggle("old", Boolean(readings.load_utc) && !(ageMs(readings.load_utc) < OLD_MS));
      setText(load.small, since(t("read.set", { value: unit(readings.set_load_n, 0, "N") }), readings.load_utc));
      setText(raw.value, unit(point?.raw_nm, 3, "N·m"));
      setText(raw.small, point ? t("read.cycles", { cycles: point.cycles, value: `${plain(point.set_frequency_hz)} Hz` }) : "");
      setText(rig.value, unit(point?.rig_nm, 3, "N·m"));
      setText(rig.small, state.live?.method ?? "");
      setText(torque.value, point && Number.isFinite(point.torque_nm) ? withUncertainty(point.torque_nm, point.U_nm, "N·m") : UNKNOWN);
      setText(torque.small, point && Number.isFinite(point.torque_nm) ? t("read.at", { value: `${plain(point.set_frequency_hz)} Hz` }) : state.live?.problem ?? "");
    },
  };
}
