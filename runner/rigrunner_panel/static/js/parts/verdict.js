// The verdict and its value, as large as possible.

import { h, setText } from "../dom.js";
import { shownNumber, withUncertainty } from "../format.js";
import { store } from "../store.js";
import { has, t } from "../texts.js";

export const SIGNS = { pass: "✓", fail: "✗" };

export function verdictText(verdict) {
  const key = `verdict.${verdict}`;
  return has(key) ? t(key) : verdict;
}

export function verdictLine() {
  const word = h("strong", { class: "verdict-word" });
  const value = h("span", { class: "verdict-value" });
  const element = h("div", { class: "verdict", role: "status" }, word, value);
  return {
    element,
    update() {
      const { live, finished, phase } = store.state;
      const final = phase === "finished" && finished;
      const verdict = final ? finished.verdict : live?.verdict ?? "";
      const headline = final ? finished.headline : live?.headline;
      const kind = verdict.replaceAll(" ", "-") || "none";
      element.className = `verdict ${kind} ${final ? "" : "so-far"}`;
      const text = verdict ? `${SIGNS[verdict] ?? "~"} ${verdictText(verdict)}` : t(final ? "verdict.none" : "verdict.not_yet");
      setText(word, verdict && !final ? t("verdict.so_far", { verdict: text }) : text);
      const result = (final && finished.result) || "";
      setText(value, headline ? withUncertainty(headline.value, headline.U, headline.unit) : shownNumber(result));
    },
  };
}
