// A scanner is a keyboard with Enter. What it sends into a question, or where there is no field, is distinguished from typing by its
// pace, and goes to the page that takes scans, or is refused: a serial number is no reason, and its Enter presses no button.

import { notify } from "./notices.js";
import { t } from "../texts.js";

const FEWEST = 3; // characters, in a field; where there is none, nobody types
const LONGEST_MS = 40; // between two characters; who types needs more

let sink = null;

// `take(text)` gets the scans that come into a question or into no field; null for a page that takes none.
export function takeScans(take) {
  sink = take;
}

// Whether a person can type a text there.
export function isField(element) {
  return Boolean(element.matches?.("input:not([type=checkbox], [type=radio], [type=file]), textarea") || element.isContentEditable || element.editContext);
}

// Keeps scans out of an element, and of its fields too where they are those of a question.
export function keepScansOut(element, { fields = false } = {}) {
  let text = "";
  let before = "";
  let last = -Infinity;

  element.addEventListener("keydown", (event) => {
    const [target] = event.composedPath(); // within the editor too, which hides what is in it
    const inField = isField(target);
    if (inField && !fields) return;
    const isNext = event.timeStamp - last <= LONGEST_MS;
    last = event.timeStamp;
    if (event.key === "Enter" && isNext && text.length >= (inField ? FEWEST : 1)) {
      event.preventDefault();
      event.stopPropagation();
      if ("value" in target && target.value !== before) {
        target.value = before;
        if (!inField) target.dispatchEvent(new Event("change")); // of a list, in which letters choose
      }
      if (sink) sink(text);
      else notify(t("scan.refused", { text }), { hint: t("scan.refused.hint") });
      text = "";
    } else if (event.key.length === 1 && !event.repeat && !event.ctrlKey && !event.metaKey) {
      if (!isNext) {
        text = "";
        before = target.value ?? "";
      } else if (event.key === " " && !inField) event.preventDefault(); // it would press a button
      text += event.key;
    } else if (event.key !== "Shift" && event.key !== "AltGraph") text = "";
  }, { capture: true });
}
