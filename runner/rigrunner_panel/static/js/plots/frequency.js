// Raw and compensated torque over the frequency, the latter with its expanded uncertainty.

import { colour } from "../theme.js";
import { t } from "../texts.js";
import { axis, chart, legend } from "./chart.js";

const EMPTY = [[0, 35], [null, null], [null, null], [null, null], [null, null]];
const CAP_PX = 4; // no wider than the point: of a bar that is shorter than it nothing stands out

export function frequencyChart() {
  let highest = 1; // of the plan, so that the axis stands still while the points fill in
  const options = () => ({
    scales: { x: { time: false, range: (plot, low, high) => [Math.min(0, low), Math.max(high, highest) * 1.05] },
      y: { range: (plot, low, high) => [Math.min(0, low ?? 0), Math.max((high ?? 1) * 1.08, 0.1)] } },
    axes: [axis({ size: 26 }), axis({ size: 46, space: 24 })],
    series: [
      {},
      { stroke: colour("raw"), paths: () => null, points: { show: true, size: 8, fill: colour("surface") } },
      { stroke: colour("compensated"), paths: () => null, points: { show: true, size: 9, fill: colour("compensated") } },
      { show: true, stroke: "transparent", paths: () => null, points: { show: false } },
      { show: true, stroke: "transparent", paths: () => null, points: { show: false } },
    ],
    hooks: { draw: [drawBars] },
  });
  const made = chart(t("plot.over_frequency"), t("plot.over_hertz"), options, EMPTY);
  made.element.append(legend([["raw point", t("plot.raw_peak")], ["compensated point", t("plot.compensated_u")]]));
  return {
    ...made,
    show(points, planned = []) {
      highest = Math.max(1, ...planned);
      made.set(points.length ? columns(points) : EMPTY);
    },
  };
}

export function columns(points) {
  const known = points.filter((point) => Number.isFinite(point.frequency_hz));
  const sorted = [...known].sort((a, b) => a.frequency_hz - b.frequency_hz);
  const end = (point, sign) =>
    Number.isFinite(point.torque_nm) && Number.isFinite(point.U_nm) ? point.torque_nm + sign * point.U_nm : null;
  return [
    sorted.map((point) => point.frequency_hz),
    sorted.map((point) => point.raw_nm ?? null),
    sorted.map((point) => point.torque_nm ?? null),
    sorted.map((point) => end(point, -1)),
    sorted.map((point) => end(point, +1)),
  ];
}

function drawBars(plot) {
  const [x, , , low, high] = plot.data;
  const { ctx } = plot;
  const cap = CAP_PX * devicePixelRatio;
  ctx.save();
  ctx.strokeStyle = colour("compensated");
  ctx.lineWidth = 2 * devicePixelRatio;
  ctx.beginPath();
  for (let i = 0; i < x.length; i += 1) {
    if (low[i] === null || high[i] === null) continue;
    const at = Math.round(plot.valToPos(x[i], "x", true)); // as the points are
    const from = plot.valToPos(low[i], "y", true);
    const to = plot.valToPos(high[i], "y", true);
    ctx.moveTo(at, from);
    ctx.lineTo(at, to);
    for (const end of [from, to]) {
      ctx.moveTo(at - cap, end);
      ctx.lineTo(at + cap, end);
    }
  }
  ctx.stroke();
  ctx.restore();
}
