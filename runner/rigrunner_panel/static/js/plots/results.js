// Figures as the server sends them: series of points or curves with their U, and limits.

import { h, show } from "../dom.js";
import { colour } from "../theme.js";
import { translate, t } from "../texts.js";
import { axis, axisWords, chart, HIDDEN, legend, padded } from "./chart.js";

const CAP_PX = 4;
const POINT_PX = 4.5;
const BAND = 0.15;
const COLOURS = ["compensated", "raw", "ink-soft", "good", "bad", "ink"];
const FIRST = 3; // series that differ by colour; the next ones are dashed and have rings, for those who see no colours
const DASH_PX = 11;
const WHOLE = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000]; // steps of a count, such as of runs

// Shows the figures that the server sends as data; a chart is built again if its axes differ.
export function resultCharts(most = 2) {
  const element = h("div", { class: "result-plots" });
  let charts = [];
  let shownNames = "";
  return {
    element,
    show(figures) {
      const shown = figures.slice(0, most);
      const names = JSON.stringify(shown.map(({ title, x, y, series }) => [title, x, y, series.map((line) => [line.name, line.kind])]));
      if (names !== shownNames) {
        for (const plot of charts) plot.leave();
        charts = shown.map(figureChart);
        shownNames = names;
        element.replaceChildren(...charts.map((plot) => plot.element));
      }
      shown.forEach((figure, i) => charts[i].show(figure));
    },
    leave() {
      for (const plot of charts) plot.leave();
    },
  };
}

function figureChart(figure) {
  let now = figure;
  const options = () => ({
    scales: { x: { time: false, range: padded(0.08) }, y: { range: padded(0.12) } },
    axes: [axis({ size: 26, ...(figure.x.unit ? {} : { incrs: WHOLE }) }), axis({ size: 62, space: 24 })],
    series: [{}, HIDDEN, HIDDEN, HIDDEN],
    hooks: { draw: [(plot) => draw(plot, now)] },
  });
  const plot = chart(translate(figure.title), t("plot.of_over", { y: axisWords(figure.y), x: axisWords(figure.x) }), options, columns([]));
  const limit = legend([["limit", t("plot.limit")]]);
  const keys = figure.series.map((line, i) => [`${paint(line, i)} ${line.kind === "line" ? "" : "point"} ${isLater(line, i) ? "later" : ""}`, translate(line.name) || t("plot.result_u")]);
  plot.element.append(h("div", { class: "legends" }, legend(keys), limit));
  return {
    ...plot,
    show(newest) {
      now = newest;
      const points = newest.series.flatMap((line) => line.points).sort((a, b) => a.x - b.x);
      const limits = newest.marks.filter((mark) => mark.is_limit && mark.axis === "y").map((mark) => mark.at);
      show(limit, limits.length || points.some((point) => Number.isFinite(point.lower) || Number.isFinite(point.upper)));
      plot.set(columns(points, limits));
    },
  };
}

// What is marked is an alarm.
function paint({ kind }, i) {
  return kind === "marked" ? "bad" : COLOURS[i % COLOURS.length];
}

function isLater({ kind }, i) {
  return kind !== "marked" && i % COLOURS.length >= FIRST;
}

// x, y, and the least and greatest of what is drawn at each point.
export function columns(points, limits = []) {
  const ends = (point) => [point.y, point.y - (point.U ?? 0), point.y + (point.U ?? 0), point.lower, point.upper, ...limits].filter(Number.isFinite);
  if (!points.length) return [[0, 1], [null, null], [null, null], [null, null]];
  return [
    points.map((point) => point.x),
    points.map((point) => point.y),
    points.map((point) => Math.min(...ends(point))),
    points.map((point) => Math.max(...ends(point))),
  ];
}

function draw(plot, figure) {
  const { ctx } = plot;
  const px = devicePixelRatio;
  const across = (value) => plot.valToPos(value, "x", true);
  const up = (value) => plot.valToPos(value, "y", true);
  const path = (paint, width = 2) => {
    ctx.lineWidth = width * px;
    ctx.beginPath();
    paint();
    ctx.stroke();
  };
  const line = (x1, y1, x2, y2) => {
    ctx.moveTo(x1, y1);
    ctx.lineTo(x2, y2);
  };
  ctx.save();
  figure.series.forEach(({ kind, points }, i) => {
    ctx.strokeStyle = colour(paint({ kind }, i));
    ctx.fillStyle = ctx.strokeStyle;
    const later = isLater({ kind }, i);
    if (kind === "line") band(ctx, points, across, up);
    if (kind === "line" || kind === "joined") {
      if (later) ctx.setLineDash([DASH_PX * px, (DASH_PX * px) / 2]);
      path(() => points.forEach((point) => ctx.lineTo(across(point.x), up(point.y))), kind === "line" ? 2 : 1);
      ctx.setLineDash([]);
    }
    if (kind === "line") return;
    path(() => {
      for (const { x, y, U } of points) {
        if (!Number.isFinite(U)) continue;
        line(across(x), up(y - U), across(x), up(y + U));
        for (const end of [up(y - U), up(y + U)]) line(across(x) - CAP_PX * px, end, across(x) + CAP_PX * px, end);
      }
    });
    if (later) ctx.fillStyle = colour("surface");
    for (const { x, y } of points) {
      ctx.beginPath();
      ctx.arc(across(x), up(y), POINT_PX * px, 0, 2 * Math.PI);
      ctx.fill();
      if (later) ctx.stroke();
    }
  });
  ctx.strokeStyle = colour("ink-soft");
  path(() => {
    for (const mark of figure.marks) {
      if (!mark.is_limit && !mark.end && mark.axis === "y") line(plot.bbox.left, up(mark.at), plot.bbox.left + plot.bbox.width, up(mark.at));
    }
  }, 1);
  ctx.strokeStyle = colour("raw");
  path(() => {
    for (const { x, lower, upper } of figure.series.flatMap((line) => line.points)) {
      for (const limit of [lower, upper]) {
        if (Number.isFinite(limit)) line(across(x) - DASH_PX * px, up(limit), across(x) + DASH_PX * px, up(limit));
      }
    }
    for (const mark of figure.marks) {
      if (mark.is_limit && mark.axis === "y") line(plot.bbox.left, up(mark.at), plot.bbox.left + plot.bbox.width, up(mark.at));
    }
  });
  ctx.restore();
}

function band(ctx, points, across, up) {
  const withU = points.filter((point) => Number.isFinite(point.U));
  ctx.globalAlpha = BAND;
  ctx.beginPath();
  for (const { x, y, U } of withU) ctx.lineTo(across(x), up(y + U));
  for (const { x, y, U } of [...withU].reverse()) ctx.lineTo(across(x), up(y - U));
  ctx.fill();
  ctx.globalAlpha = 1;
}
