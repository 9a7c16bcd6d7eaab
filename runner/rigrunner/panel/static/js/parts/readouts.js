// The large numbers: what is set, what is measured, and what comes out.

import { h, setText } from "../dom.js";
import { fixed, plain, UNKNOWN, withUncertainty } from "../format.js";
import { store } from "../store.js";
import { t } from "../texts.js";

function readout(key, kind = "") {
  const value = h("span", { class: "readout-value" }, UNKNOWN);
  const small = h("span", { class: "readout-small" });
  return { element: h("div", { class: `readout ${kind}` }, h("span", { class: "readout-name" }, t(key)), value, small), value, small };
}

// The point that is being recorded, or the last one that was analysed.
export function presentPoint(state) {
  const points = state.live?.points ?? [];
  const name = state.progress?.recording;
  return points.find((point) => point.recording === name) ?? points.at(-1) ?? null;
}

export function readouts() {
  const frequency = readout("read.frequency");
  const load = readout("read.load");
  const raw = readout("read.raw", "raw");
  const rig = readout("read.compensation");
  const torque = readout("read.torque", "compensated");
  const rows = [frequency, load, raw, rig, torque];
  return {
    element: h("div", { class: "readouts" }, rows.map((row) => row.element)),
    update() {
      const { state } = store;
      const { readings } = state;
      const point = presentPoint(state);
      const unit = (number, decimals, symbol) => (Number.isFinite(number) ? `${fixed(number, decimals)} ${symbol}` : UNKNOWN);
      const here = point && point.set_frequency_hz === readings.set_frequency_hz ? point : null;
      const turning = state.pause ? null : readings.frequency_hz ?? here?.frequency_hz; // what is paused was measured before
      setText(frequency.value, unit(turning, 2, "Hz"));
      setText(frequency.small, t("read.set", { value: unit(readings.set_frequency_hz, 2, "Hz") }));
      setText(load.value, unit(readings.load_n ?? here?.load_n, 0, "N"));
      setText(load.small, t("read.set", { value: unit(readings.set_load_n, 0, "N") }));
      setText(raw.value, unit(point?.raw_nm, 3, "N·m"));
      setText(raw.small, point ? t("read.cycles", { cycles: point.cycles, value: `${plain(point.set_frequency_hz)} Hz` }) : "");
      setText(rig.value, unit(point?.rig_nm, 3, "N·m"));
      setText(rig.small, state.live?.method ?? "");
      setText(torque.value, point && Number.isFinite(point.torque_nm) ? withUncertainty(point.torque_nm, point.U_nm, "N·m") : UNKNOWN);
      setText(torque.small, point && Number.isFinite(point.torque_nm) ? t("read.at", { value: `${plain(point.set_frequency_hz)} Hz` }) : state.live?.problem ?? "");
    },
  };
}
