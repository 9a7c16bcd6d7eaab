// Raw and compensated torque over one swing, from 0 to 360 degrees of the crank.

import { colour } from "../theme.js";
import { t } from "../texts.js";
import { axis, chart, legend } from "./chart.js";

const TURN_DEG = 360;
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
  made.element.append(legend([["raw", t("plot.raw")], ["compensated", t("plot.compensated")]]));
  return {
    ...made,
    show(frame) {
      made.set(frame ? curves(frame) : EMPTY);
    },
  };
}

function curves({ curves: { raw_nm: raw, compensated_nm: compensated } }) {
  const phase = Array.from(raw, (_, i) => (TURN_DEG * i) / Math.max(raw.length - 1, 1));
  return [phase, raw, compensated ?? new Array(raw.length).fill(null)];
}
