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
  const plot = chart(t("plots.trend"), t("plot.seconds"), options, EMPTY);
  return {
    ...plot,
    show(trend) {
      if (!trend.minimum.length) {
        plot.set(EMPTY);
        return;
      }
      plot.call(t("plot.channel", { channel: trend.channel }), [trend.unit === "1" ? "" : trend.unit, t("plot.seconds")].filter(Boolean).join(" "));
      const times = trend.minimum.map((_, i) => (trend.first + i) * trend.stepS);
      plot.set([times, trend.minimum.map(finite), trend.maximum.map(finite)]);
    },
  };
}

function finite(value) {
  return Number.isNaN(value) ? null : value;
}
