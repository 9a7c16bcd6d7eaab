// Results of any quantity over a coordinate, with their expanded uncertainty and their limits.

import { h, show } from "../dom.js";
import { colour } from "../theme.js";
import { t } from "../texts.js";
import { axis, chart, legend } from "./chart.js";

const CAP_PX = 4;
const DASH_PX = 11;

// Shows the figures that the server sends as data; a chart is made anew where its axes are others.
export function resultCharts(most = 2) {
  const element = h("div", { class: "result-plots" });
  let charts = [];
  let known = "";
  return {
    element,
    show(figures) {
      const shown = figures.slice(0, most);
      const names = JSON.stringify(shown.map((figure) => [figure.title, figure.x, figure.y]));
      if (names !== known) {
        for (const each of charts) each.leave();
        charts = shown.map(figureChart);
        known = names;
        element.replaceChildren(...charts.map((each) => each.element));
      }
      shown.forEach((figure, i) => charts[i].show(figure));
    },
    leave() {
      for (const each of charts) each.leave();
    },
  };
}

function figureChart(figure) {
  let points = [];
  const options = () => ({
    scales: { x: { time: false, range: padded(0.08) }, y: { range: padded(0.12) } },
    axes: [axis({ size: 26 }), axis({ size: 62, space: 24 })],
    series: [
      {},
      { stroke: colour("compensated"), paths: () => null, points: { show: true, size: 9, fill: colour("compensated") } },
      { stroke: "transparent", paths: () => null, points: { show: false } },
      { stroke: "transparent", paths: () => null, points: { show: false } },
    ],
    hooks: { draw: [(plot) => draw(plot, points)] },
  });
  const made = chart(figure.title, t("plot.of_over", { y: words(figure.y), x: words(figure.x) }), options, columns([]));
  const limit = legend([["limit", t("plot.limit")]]);
  made.element.append(h("div", { class: "legends" }, legend([["compensated point", t("plot.result_u")]]), limit));
  return {
    ...made,
    show(newest) {
      points = newest.series.flatMap((each) => each.points).sort((a, b) => a.x - b.x);
      show(limit, points.some((point) => Number.isFinite(point.lower) || Number.isFinite(point.upper)));
      made.set(columns(points));
    },
  };
}

function words({ name, unit }) {
  return unit && unit !== "1" ? `${name} / ${unit}` : name;
}

function padded(share) {
  return (plot, low, high) => {
    if (low === null || high === null) return [0, 1];
    const margin = (high - low || Math.abs(high) || 1) * share;
    return [low - margin, high + margin];
  };
}

// x, y, and the least and greatest of what is drawn at each point.
export function columns(points) {
  const ends = (point) => [point.y, point.y - (point.U ?? 0), point.y + (point.U ?? 0), point.lower, point.upper].filter(Number.isFinite);
  if (!points.length) return [[0, 1], [null, null], [null, null], [null, null]];
  return [
    points.map((point) => point.x),
    points.map((point) => point.y),
    points.map((point) => Math.min(...ends(point))),
    points.map((point) => Math.max(...ends(point))),
  ];
}

function draw(plot, points) {
  const { ctx } = plot;
  const px = devicePixelRatio;
  const line = (x1, y1, x2, y2) => {
    ctx.moveTo(x1, y1);
    ctx.lineTo(x2, y2);
  };
  const stroke = (name, width, paint) => {
    ctx.strokeStyle = colour(name);
    ctx.lineWidth = width * px;
    ctx.beginPath();
    for (const point of points) paint(point, plot.valToPos(point.x, "x", true), (value) => plot.valToPos(value, "y", true));
    ctx.stroke();
  };
  ctx.save();
  stroke("compensated", 2, (point, x, at) => {
    if (!Number.isFinite(point.U)) return;
    const ends = [at(point.y - point.U), at(point.y + point.U)];
    line(x, ends[0], x, ends[1]);
    for (const end of ends) line(x - CAP_PX * px, end, x + CAP_PX * px, end);
  });
  stroke("raw", 2, (point, x, at) => {
    for (const limit of [point.lower, point.upper]) {
      if (Number.isFinite(limit)) line(x - DASH_PX * px, at(limit), x + DASH_PX * px, at(limit));
    }
  });
  ctx.restore();
}
