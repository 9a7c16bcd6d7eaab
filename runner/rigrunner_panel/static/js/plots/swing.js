// Raw and compensated torque over one swing, from 0 to 360 degrees of the crank.

import { h, setText } from "../dom.js";
import { fixed } from "../format.js";
import { colour } from "../theme.js";
import { t } from "../texts.js";
import { axis, chart, legend } from "./chart.js";

const TURN_DEG = 360;
const UNKEPT = "-"; // the name of a recording of which statistics alone are kept
const EMPTY = [[0, TURN_DEG], [null, null], [null, null]];

export function swingChart() {
  const options = () => ({
    scales: { x: { time: false, range: [0, TURN_DEG] } },
    axes: [axis({ incrs: [30, 45, 90], size: 26 }), axis({ size: 46 })],
    series: [
      {},
      { stroke: colour("raw"), width: 2, points: { show: false } },
      { stroke: colour("compensated"), width: 3, points: { show: false } },
    ],
  });
  const made = chart(t("plot.swing"), t("plot.over_crank"), options, EMPTY);
  const of = h("span", { class: "plot-of" });
  const key = legend([["raw", t("plot.raw")], ["compensated", t("plot.compensated")]]);
  key.append(of);
  made.element.append(key);
  return {
    ...made,
    // `recording` is what is being recorded now; a swing of another one is a past one, and looks so.
    show(frame, recording) {
      const isPast = Boolean(frame) && frame.recording !== recording;
      made.set(frame ? curves(frame) : EMPTY);
      made.element.classList.toggle("past", isPast);
      setText(of, frame ? t(isPast ? "plot.past" : "plot.of", { name: frame.recording === UNKEPT ? t("plot.unkept") : frame.recording, value: `${fixed(frame.frequency_hz, 2)} Hz` }) : "");
    },
  };
}

function curves({ curves: { raw_nm: raw, compensated_nm: compensated } }) {
  const phase = Array.from(raw, (_, i) => (TURN_DEG * i) / Math.max(raw.length - 1, 1));
  return [phase, raw, compensated ?? new Array(raw.length).fill(null)];
}
