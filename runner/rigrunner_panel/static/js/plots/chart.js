// uPlot in the panel's colours. A chart is drawn once a frame at most, with the newest data alone.

import uPlot from "../../vendor/uplot/uPlot.esm.js";
import { h, setText } from "../dom.js";
import { plain } from "../format.js";
import { translate } from "../texts.js";
import { colour, onTheme } from "../theme.js";

const FONT = "14px system-ui, sans-serif";

export function axis(more = {}) {
  return {
    font: FONT,
    stroke: () => colour("ink-soft"),
    grid: { stroke: () => colour("line"), width: 1 },
    ticks: { stroke: () => colour("line"), width: 1, size: 4 },
    gap: 3,
    values: (plot, splits) => splits.map(marked),
    ...more,
  };
}

function marked(value) {
  return value === null ? "" : plain(value);
}

// A series that a hook draws: uPlot makes room for its values alone.
export const HIDDEN = { stroke: "transparent", paths: () => null, points: { show: false } };

// The range of an axis: that of the values, with a share of it as margin.
export function padded(share) {
  return (plot, low, high) => {
    if (low === null || high === null) return [0, 1];
    const margin = (high - low || Math.abs(high) || 1) * share;
    return [low - margin, high + margin];
  };
}

// What an axis shows: its name, with its unit.
export function axisWords({ name, unit }) {
  return unit && unit !== "1" ? `${translate(name)} / ${unit}` : translate(name);
}

// `options` is made again with the colours of the theme. Returns {element, set(data), leave}; `units` says what is over what.
export function chart(title, units, options, empty) {
  const plotHost = h("div", { class: "plot-host" });
  const shown = h("span", {}, title);
  const over = h("span", { class: "plot-units" }, units);
  const summary = h("figcaption", { class: "plot-title" }, shown, over);
  const element = h("figure", { class: "plot", role: "group", "aria-label": title }, summary, plotHost);
  let data = empty;
  let plot = null;
  let waits = false;

  function size() {
    return { width: Math.max(plotHost.clientWidth, 50), height: Math.max(plotHost.clientHeight, 50) };
  }

  function make() {
    plot?.destroy();
    plot = new uPlot({ ...options(), ...size(), cursor: { show: false }, legend: { show: false } }, data, plotHost);
  }

  function draw() {
    waits = false;
    if (!element.isConnected) return;
    if (!plot) make();
    plot.setData(data);
  }

  const watcher = new ResizeObserver(() => {
    if (plot) plot.setSize(size());
    else if (element.isConnected && plotHost.clientWidth) make();
  });
  watcher.observe(plotHost);
  const forget = onTheme(() => {
    if (plot) make();
  });

  return {
    element,
    set(newest) {
      data = newest;
      if (waits) return;
      waits = true;
      requestAnimationFrame(draw);
    },
    call(newTitle, newUnits) {
      setText(shown, newTitle);
      setText(over, newUnits);
      element.setAttribute("aria-label", newTitle);
    },
    leave() {
      watcher.disconnect();
      forget();
      plot?.destroy();
      plot = null;
    },
  };
}

export function legend(entries) {
  return h("div", { class: "legend", "aria-hidden": "true" },
    entries.map(([kind, text]) => h("span", { class: `key ${kind}` }, text)));
}
