// A scanner is a keyboard with Enter. What it sends into a question is told from typing by its pace, and goes to the
// page that takes scans, or is refused: a serial number is no reason.

import { tell } from "./notices.js";
import { t } from "../texts.js";

const FEWEST = 3; // characters
const LONGEST_MS = 40; // between two characters; who types needs more

let sink = null;

// `take(text)` gets the scans that come into a question; null for a page that takes none.
export function takeScans(take) {
  sink = take;
}

// Keeps scans out of the fields of an element.
export function keepScansOut(element) {
  let text = "";
  let before = "";
  let last = -Infinity;

  element.addEventListener("keydown", (event) => {
    const isNext = event.timeStamp - last <= LONGEST_MS;
    last = event.timeStamp;
    if (event.key === "Enter" && isNext && text.length >= FEWEST) {
      event.preventDefault();
      event.stopPropagation();
      if ("value" in event.target) event.target.value = before;
      if (sink) sink(text);
      else tell(t("scan.refused", { text }), { hint: t("scan.refused.hint") });
      text = "";
    } else if (event.key.length === 1 && !event.repeat && !event.ctrlKey && !event.metaKey) {
      if (!isNext) {
        text = "";
        before = event.target.value ?? "";
      }
      text += event.key;
    } else if (event.key !== "Shift") text = "";
  }, { capture: true });
}
