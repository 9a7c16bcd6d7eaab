// Several runs in one figure: their results, and a channel of a recording over time.

import { get } from "../client.js";
import { fill, h, show } from "../dom.js";
import { shownNumber, UNKNOWN, withUncertainty } from "../format.js";
import { working } from "../parts/working.js";
import { resultCharts } from "../plots/results.js";
import { notifyError } from "../parts/notices.js";
import { translate, t } from "../texts.js";

const MOST_FIGURES = 6;

function translated({ title, x, y, ...more }) {
  return { title: translate(title), x: { ...x, name: translate(x.name) }, y: { ...y, name: translate(y.name) }, ...more };
}

export function overlayPage(...runs) {
  const results = resultCharts(MOST_FIGURES);
  const curve = resultCharts(1);
  const recording = h("select", { id: "overlay-recording", onchange: chooseRecording });
  const channel = h("select", { id: "overlay-channel", onchange: showCurve });
  const status = h("div", { role: "status" });
  const rows = h("div", { class: "overlay-rows" });
  const choice = h("div", { class: "row", hidden: true },
    h("div", { class: "field" }, h("label", { for: "overlay-recording" }, t("overlay.recording")), recording),
    h("div", { class: "field" }, h("label", { for: "overlay-channel" }, t("overlay.channel")), channel));
  let recordings = {};

  // Results over no set-point, a line for each of them and run.
  function table(entries) {
    return entries.map(({ name, unit, values }) => h("table", { class: "results" },
      h("caption", {}, [shownNumber(name), unit === "1" ? "" : t("results.in_unit", { unit })].filter(Boolean).join(", ")),
      h("tbody", {}, runs.map((run) => h("tr", {}, h("th", { scope: "row" }, run), h("td", { class: "number" }, values[run] ? withUncertainty(values[run][0], values[run][1] ?? NaN, "") : UNKNOWN))))));
  }

  async function request(more = {}) {
    try {
      return await working(status, t("overlay.reading"), () => get("overlay", { runs: runs.join(","), ...more }));
    } catch (error) {
      notifyError(error);
      return null;
    }
  }

  async function load() {
    const answer = await request();
    if (!answer) return;
    recordings = answer.recordings;
    results.show(answer.results.map(translated));
    fill(rows, answer.rows.length ? table(answer.rows) : null);
    if (!answer.results.length && !answer.rows.length) fill(results.element, h("p", { class: "soft" }, t("overlay.no_results")));
    show(choice, Object.keys(recordings).length > 0);
    if (choice.hidden) fill(curve.element, h("p", { class: "soft" }, t("overlay.no_recordings")));
    fill(recording, Object.keys(recordings).map((name) => h("option", { value: name }, name)));
    chooseRecording();
  }

  function chooseRecording() {
    const before = channel.value;
    fill(channel, (recordings[recording.value] ?? []).map((name) => h("option", { value: name, selected: name === before }, name)));
    showCurve();
  }

  async function showCurve() {
    if (!channel.value) return;
    const answer = await request({ recording: recording.value, channel: channel.value });
    if (answer?.curve) curve.show([translated(answer.curve)]);
  }

  load();
  return {
    title: t("overlay.title"),
    element: h("div", { class: "page overlay" },
      h("div", { class: "head" }, h("h1", {}, t("overlay.title")), h("p", {}, runs.map((run) => h("a", { class: "run-link", href: `#/runs/${encodeURIComponent(run)}` }, run)))),
      status,
      h("div", { class: "two overlay-columns" },
        h("section", { class: "card" }, h("h2", {}, t("results.title")), results.element, rows),
        h("section", { class: "card" }, h("h2", {}, t("overlay.curves")),
          choice, curve.element))),
    leave() {
      results.leave();
      curve.leave();
    },
  };
}
