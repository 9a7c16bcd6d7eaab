// The latest curve that an analysis shows of a recording, such as one cycle over its phase.

import { h, setText } from "../dom.js";
import { fixed, plain } from "../format.js";
import { colour } from "../theme.js";
import { translate, t } from "../texts.js";
import { axis, axisWords, chart, legend } from "./chart.js";

const X = "x"; // the array with the values of x; the others are series
const UNKEPT = "-"; // the name of a recording of which only the statistics are kept
const EMPTY = [[0, 1], [null, null], [null, null]];
const PAINTS = ["raw", "compensated"];
const STEPS_DEG = [30, 45, 90];
const LEAST_OLD_S = 1;
const MISSED = 3; // cycles without a curve

function curveChart({ title, x, y }) {
  const of = h("span", { class: "plot-of" });
  const keys = h("div", { class: "legend" });
  const range = Number.isFinite(x.low) && Number.isFinite(x.high) ? { range: [x.low, x.high] } : {};
  const options = () => ({
    scales: { x: { time: false, ...range } },
    axes: [axis({ size: 26, ...(x.unit === "°" ? { incrs: STEPS_DEG } : {}) }), axis({ size: 46 })],
    series: [{}, ...PAINTS.map((paint, i) => ({ stroke: colour(paint), width: 2 + i, points: { show: false } }))],
  });
  const plot = chart(translate(title), t("plot.of_over", { y: axisWords(y), x: axisWords(x) }), options, EMPTY);
  plot.element.append(keys);
  let shown = "";
  return {
    ...plot,
    // `recording` is what is being recorded now; a curve of another one is a past one, and looks so. One that
    // should have been followed by another one looks old, and says how old it is.
    show({ curves, recording: drawn, frequency_hz: hertz, since }, recording) {
      const { [X]: xs, ...series } = curves;
      const names = Object.keys(series);
      if (names.join() !== shown) {
        shown = names.join();
        keys.replaceChildren(...legend(names.map((name, i) => [PAINTS[i], translate(name)])).childNodes, of);
      }
      const values = names.map((name) => series[name]);
      plot.set([xs, values[0], values[1] ?? new Array(xs.length).fill(null)]);
      const isPast = drawn !== recording;
      const ageS = (performance.now() - since) / 1000;
      const isLate = !isPast && ageS > Math.max(LEAST_OLD_S, hertz > 0 ? MISSED / hertz : 0);
      plot.element.classList.toggle("past", isPast || isLate);
      const name = [drawn === UNKEPT ? t("plot.unkept") : drawn, Number.isFinite(hertz) ? `${fixed(hertz, 2)} Hz` : ""].filter(Boolean).join(", ");
      setText(of, isPast ? t("plot.past", { name }) : isLate ? t("plot.late", { name, seconds: plain(Math.round(ageS)) }) : name);
    },
  };
}

// The chart of the latest curve, built again if its axes differ.
export function latestCurve() {
  const element = h("div", { class: "plot-curve" });
  let current = null;
  let title = "";
  return {
    element,
    show(frame, recording) {
      if (frame?.title !== title) {
        current?.leave();
        current = frame ? curveChart(frame) : null;
        title = frame?.title;
        element.replaceChildren(...(current ? [current.element] : []));
      }
      current?.show(frame, recording);
    },
    leave() {
      current?.leave();
    },
  };
}
