// The steps of the plan with how far each is, the share that is done, and the time that is left.

import { fill, h, setText } from "../dom.js";
import { duration } from "../format.js";
import { store } from "../store.js";
import { translate, t } from "../texts.js";

const SIGNS = { ".": "", r: "▶", o: "✓", x: "✗", s: "↷" };
const WORDS = { ".": "to_come", r: "running", o: "done", x: "failed", s: "skipped" };

// The words of a step; what the procedure of a laboratory asks stays in its own words.
export function stepWords({ text }) {
  return translate(text);
}

export function stepList() {
  const bar = h("progress", { max: "1", value: "0", "aria-label": t("steps.progress") });
  const left = h("span", { class: "left" });
  const list = h("ol", { class: "steps", tabindex: "0", "aria-label": t("steps.title") });
  let rows = [];
  let shown = null;
  let seen = null;

  function build(plan) {
    shown = plan;
    rows = (plan?.steps ?? []).map((step) => {
      const sign = h("span", { class: "step-sign", role: "img" });
      const row = h("li", { class: "step" }, sign, h("span", {}, stepWords(step)));
      return { row, sign, state: "" };
    });
    fill(list, rows.map((entry) => entry.row));
  }

  function mark(states) {
    rows.forEach((entry, i) => {
      const state = states[i] ?? ".";
      if (entry.state === state) return;
      entry.state = state;
      entry.row.className = `step ${WORDS[state]}`;
      entry.sign.setAttribute("aria-label", t(`steps.${WORDS[state]}`));
      setText(entry.sign, SIGNS[state]);
      if (state === "r") {
        entry.row.setAttribute("aria-current", "step");
      } else entry.row.removeAttribute("aria-current");
    });
    const present = rows.find((entry) => entry.state === "r") ?? rows.find((entry) => entry.state === ".");
    if (present && present.row !== seen) reveal(present.row);
  }

  // A list that is not on the page yet cannot be scrolled: the next frame finds it there.
  function reveal(row) {
    seen = row;
    requestAnimationFrame(() => {
      list.scrollTop = row.offsetTop - list.clientHeight / 3;
    });
  }

  return {
    element: h("section", { class: "steps-card" }, h("div", { class: "eta" }, bar, left), list),
    update(changed) {
      const { plan, progress } = store.state;
      if (changed.has("plan") || shown !== plan) build(plan);
      if (!progress) {
        setText(left, "");
        return;
      }
      mark(progress.states);
      bar.value = progress.estimated_s ? Math.min(progress.done_s / (progress.done_s + progress.left_s || 1), 1) : 0;
      const time = t("steps.left", { time: duration(progress.left_s) });
      if (store.state.phase === "finished") {
        setText(left, "");
        return;
      }
      const { scanned, scan_points: points } = progress;
      setText(left, points ? t("steps.point", { number: scanned, points, time }) : time);
    },
  };
}
