// What takes longer than a moment: a bar that moves, and for how long it has been going on.

import { fill, h, setText } from "../dom.js";
import { t } from "../texts.js";

const MOMENT_MS = 300;

// Shows it in an element until the work is done; returns what the work gives.
export async function working(place, what, work) {
  const began = Date.now();
  const words = h("p", { class: "soft" }, what);
  fill(place);
  const bar = h("div", { class: "working" }, h("progress", { "aria-label": what }), words);
  const shown = setTimeout(() => place.append(bar), MOMENT_MS);
  const timer = setInterval(() => setText(words, t("working", { what, seconds: Math.round((Date.now() - began) / 1000) })), 1000);
  try {
    return await work();
  } finally {
    clearTimeout(shown);
    clearInterval(timer);
    bar.remove();
  }
}
