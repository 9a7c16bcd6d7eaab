// A recorded channel over the time of the run: between the least and the greatest sample of each column.

import { colour } from "../theme.js";
import { t } from "../texts.js";
import { axis, chart } from "./chart.js";

const EMPTY = [[0, 1], [null, null], [null, null]];

export function trendChart() {
  const options = () => ({
    scales: { x: { time: false } },
    axes: [axis({ size: 26 }), axis({ size: 46, space: 24 })],
    bands: [{ series: [2, 1], fill: colour("raw-fill") }],
    series: [
      {},
      { stroke: colour("raw"), width: 1, points: { show: false }, spanGaps: false },
      { stroke: colour("raw"), width: 1, points: { show: false }, spanGaps: false },
    ],
  });
  const made = chart(t("plots.trend"), t("plot.seconds"), options, EMPTY);
  return {
    ...made,
    show(trend) {
      if (!trend.minimum.length) {
        made.set(EMPTY);
        return;
      }
      made.call(t("plot.channel", { channel: trend.channel }), [trend.unit === "1" ? "" : trend.unit, t("plot.seconds")].filter(Boolean).join(" "));
      const at = trend.minimum.map((_, i) => (trend.first + i) * trend.stepS);
      made.set([at, trend.minimum.map(known), trend.maximum.map(known)]);
    },
  };
}

function known(value) {
  return Number.isNaN(value) ? null : value;
}
