// Values of channels during the last minute, as far as this page has received them; none of an earlier run.

import { listen, store } from "./store.js";

export const WINDOW_MS = 60000;

const past = new Map(); // name to [[ms, value], ...]
let of = "";

// Returns the values of a channel as [[ms, value], ...], the oldest first.
export function pastOf(name) {
  return past.get(name) ?? [];
}

// Returns [[x, y], ...]: each value of a channel with the latest one of another at that time.
export function paired(xs, ys) {
  const pairs = [];
  let at = -1;
  for (const [ms, y] of ys) {
    while (at + 1 < xs.length && xs[at + 1][0] <= ms) at += 1;
    if (at >= 0) pairs.push([xs[at][1], y]);
  }
  return pairs;
}

listen((changed) => {
  if (!changed.has("channels") && !changed.has("job")) return;
  const { job, channels = [] } = store.state ?? {};
  const key = `${job?.run}${channels.map((channel) => channel.name).join()}`;
  if (key !== of) past.clear();
  of = key;
  for (const { name, utc, value } of channels) {
    if (!utc || !Number.isFinite(value)) continue;
    const ms = Date.parse(utc);
    const values = past.get(name) ?? [];
    if (values.at(-1)?.[0] !== ms) values.push([ms, value]);
    while (values[0][0] < ms - WINDOW_MS) values.shift();
    past.set(name, values);
  }
});
