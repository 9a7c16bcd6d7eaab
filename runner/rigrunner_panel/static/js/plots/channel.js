// A channel over the last minute, or over another channel, as the page has seen them.

import { pastOf, paired, WINDOW_MS } from "../past.js";
import { t } from "../texts.js";
import { colour } from "../theme.js";
import { axis, chart, HIDDEN, padded } from "./chart.js";

const POINT_PX = 2.5;
const MARGIN = 0.08;
const EMPTY = [[0, 1], [null, null]];

// `y` and `x` are channels; without `x` it is over time. `show()` draws the values so far.
export function channelChart(y, x = null) {
  let pairs = [];
  const options = () => ({
    scales: { x: { time: false, range: x ? padded(MARGIN) : [-WINDOW_MS / 1000, 0] }, y: { range: padded(MARGIN) } },
    axes: [axis({ size: 26 }), axis({ size: 62, space: 16 })],
    series: [{}, HIDDEN],
    hooks: { draw: [(plot) => draw(plot, pairs, Boolean(x))] },
  });
  const words = (channel) => (channel.unit === "1" ? channel.name : `${channel.name} / ${channel.unit}`);
  const title = x ? t("plot.of_over", { y: y.name, x: x.name }) : t("plot.channel", { channel: y.name });
  const plot = chart(title, t("plot.of_over", { y: words(y), x: x ? words(x) : "s" }), options, EMPTY);
  return {
    ...plot,
    show() {
      const ys = pastOf(y.name);
      const end = ys.at(-1)?.[0];
      pairs = x ? paired(pastOf(x.name), ys) : ys.map(([ms, value]) => [(ms - end) / 1000, value]);
      const sorted = [...pairs].sort((a, b) => a[0] - b[0]);
      plot.set(sorted.length ? [sorted.map((pair) => pair[0]), sorted.map((pair) => pair[1])] : EMPTY);
    },
  };
}

// A line over time; points over another channel, because nothing is known between two readings.
function draw(plot, pairs, asPoints) {
  const { ctx } = plot;
  ctx.save();
  ctx.strokeStyle = ctx.fillStyle = colour("accent");
  ctx.lineWidth = 2 * devicePixelRatio;
  ctx.beginPath();
  for (const [x, y] of pairs) {
    const at = [plot.valToPos(x, "x", true), plot.valToPos(y, "y", true)];
    if (asPoints) ctx.rect(at[0] - POINT_PX * devicePixelRatio, at[1] - POINT_PX * devicePixelRatio, 2 * POINT_PX * devicePixelRatio, 2 * POINT_PX * devicePixelRatio);
    else ctx.lineTo(...at);
  }
  if (asPoints) ctx.fill();
  else ctx.stroke();
  ctx.restore();
}
