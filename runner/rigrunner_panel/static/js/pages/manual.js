// By hand: set frequency and load within limits, watch the torque, record a point.

import { personName } from "../client.js";
import { button, fill, h, setText, show } from "../dom.js";
import { draft } from "../draft.js";
import { plain, typedNumber } from "../format.js";
import { alarmStrip } from "../parts/alarms.js";
import { channelList } from "../parts/channels.js";
import { isBusy } from "../parts/bar.js";
import { endedBanners } from "../parts/ended.js";
import { field } from "../parts/field.js";
import { refusedWords } from "../parts/notices.js";
import { preflightCard } from "../parts/preflight.js";
import { liveResults } from "../parts/results.js";
import { readouts } from "../parts/readouts.js";
import { latestCurve } from "../plots/curve.js";
import { resultCharts } from "../plots/results.js";
import { steer, steerOrRefuse } from "../steer.js";
import { listen, store } from "../store.js";
import { translate, t } from "../texts.js";
import { titlesOf } from "../titles.js";

const CYCLES = 10;
const FEWEST_CYCLES = 3;
const MOST_CYCLES = 1000;

export function manualPage() {
  const curve = latestCurve();
  const figures = resultCharts(1);
  const channels = channelList();
  const numbers = readouts();
  const alarms = alarmStrip();
  const opener = openCard();
  const drives = h("div", { class: "drives" });
  const recording = h("p", { class: "soft", role: "status" });
  const cycles = field(t("manual.cycles"), h("input", { type: "text", inputmode: "numeric", id: "cycles", autocomplete: "off", value: String(CYCLES) }), { kind: "narrow" });
  const record = button(t("manual.record"), () => recordPoint(), { kind: "primary big" });
  const close = button(t("manual.close"), () => steer("manual/close"), { kind: "big" });
  const points = liveResults();
  const bench = h("div", { class: "manual-bench" },
    numbers.element,
    h("div", { class: "manual-plots" }, channels.element, curve.element, figures.element),
    h("div", { class: "manual-side" },
      h("section", { class: "card" }, h("h2", {}, t("manual.drives")), drives),
      h("section", { class: "card manual-record" }, h("h2", {}, t("manual.points")),
        h("div", { class: "row" }, cycles.element, record), recording, points.element)),
    alarms.element);
  const element = h("div", { class: "page manual" }, h("div", { class: "head" }, h("h1", {}, t("manual.title")), h("div", { class: "row" }, channels.watch, close)), opener.element, bench);
  let built = "";

  function recordPoint() {
    const count = Number(cycles.value());
    const fits = Number.isInteger(count) && count >= FEWEST_CYCLES && count <= MOST_CYCLES;
    cycles.refuse(fits ? "" : t("manual.cycles_range", { low: FEWEST_CYCLES, high: MOST_CYCLES }));
    if (fits) steer("manual/record", { cycles: count });
    else cycles.control.focus();
  }

  function update(changed) {
    const { state } = store;
    if (!state) return;
    const open = state.phase === "manual" && state.manual;
    show(bench, Boolean(open) || (state.job?.kind === "manual" && state.phase !== "idle" && state.phase !== "finished"));
    show(opener.element, !open && state.job?.kind !== "manual" || state.phase === "finished" || state.phase === "idle");
    show(close, Boolean(open));
    show(channels.watch, Boolean(open));
    opener.update();
    numbers.update();
    alarms.update();
    record.disabled = close.disabled = !open;
    for (const control of drives.querySelectorAll("button, input")) control.disabled = !open;
    if (changed.has("live")) {
      figures.show((state.live?.figures ?? []).slice(-1));
      points.show((state.live?.results ?? []).filter((result) => !result.is_ongoing));
    }
    if (!open) return;
    const names = state.manual.drives.map((drive) => drive.name).join();
    if (names !== built) {
      built = names;
      fill(drives, state.manual.drives.map(driveRow));
    }
    setText(recording, recordedWords(state.manual));
  }

  // The manual mode watches all the time: its latest curve is always one of now.
  function showCurve() {
    curve.show(store.lastCurve, store.lastCurve?.recording);
  }

  const forget = listen((changed) => {
    if (changed.has("curve")) showCurve();
    if (changed.size > 1 || !(changed.has("curve") || changed.has("trend"))) update(changed);
  });
  const aging = setInterval(() => {
    if (store.state) numbers.update();
    if (store.lastCurve) showCurve();
  }, 500);
  queueMicrotask(() => {
    update(new Set(["live", "manual"]));
    showCurve();
  });
  return {
    title: t("manual.title"),
    element,
    leave() {
      forget();
      clearInterval(aging);
      for (const part of [curve, figures, channels]) part.leave();
    },
  };
}

// What is recorded now, why the last request was refused, or how much is there: a point may have no result.
function recordedWords({ recording, refused, points, last }) {
  if (recording) return t("manual.recording", { name: recording });
  return translate(refused) || (points ? t("manual.recorded", { count: points, name: last }) : "");
}

function openCard() {
  const { procedure, station } = draft();
  const text = h("p", {}, procedure && station ? "" : t("manual.choose"));
  if (procedure && station) Promise.all([titlesOf("procedures"), titlesOf("stations")]).then(([tests, rigs]) => setText(text, t("manual.with", { procedure: tests.get(procedure) ?? procedure, station: rigs.get(station) ?? station })));
  const open = button(t("manual.open"), () => steer("manual/open", { procedure, station, operator: personName() }), { kind: "primary big" });
  const choose = h("a", { class: "button big", href: "#/" }, t("choose.title"));
  const ended = h("div", { class: "stack", hidden: true });
  const hint = h("p", { class: "soft", role: "status" });
  const card = h("section", { class: "card" }, ended, h("p", { class: "soft" }, t("manual.about")), text, h("div", { class: "row" }, open, choose), hint);
  const preflight = procedure && station ? preflightCard({ procedure, station }) : null;

  function judge() {
    const phase = store.state?.phase;
    const inUse = isBusy(store.state) && phase !== "checking";
    open.disabled = !preflight?.may() || preflight.override() !== null || !(phase === "idle" || phase === "finished");
    setText(hint, inUse ? t("manual.in_use") : preflight && !preflight.done() ? t("setup.needs_preflight") : preflight && !preflight.may() ? t("setup.needs_fixing") : "");
  }

  if (preflight) preflight.onchange = judge;
  return {
    element: h("div", { class: "two manual-open" }, card, preflight?.element),
    update() {
      const { phase, job, finished } = store.state ?? {};
      const stored = phase === "finished" && job?.kind === "manual" && finished?.run;
      show(ended, Boolean(stored));
      if (stored) fill(ended, endedBanners(finished.error, { isNow: true }), h("p", { class: "banner info" }, h("span", {}, t("manual.ended")), h("a", { class: "button", href: `#/runs/${encodeURIComponent(finished.run)}` }, t("manual.see"))));
      preflight?.update();
      judge();
    },
  };
}

function driveRow(drive) {
  const id = `drive-${drive.name}`;
  const input = h("input", { type: "text", id, inputmode: "decimal", autocomplete: "off", value: plain(drive.set ?? 0).replace("−", "-") });
  const limits = t("manual.limits", { low: plain(drive.minimum), high: plain(drive.maximum), unit: drive.unit });
  const setField = field(`${translate(drive.long_name)} (${drive.unit})`, input, { hint: limits });

  async function send(text) {
    let refused = "";
    try {
      await steerOrRefuse("manual/set", { drive: drive.name, value: /[a-z%°]/i.test(text) ? text : `${text} ${drive.unit}` });
    } catch (error) {
      refused = refusedWords(error);
    }
    setField.refuse(refused);
  }

  const form = h("form", { class: "drive", onsubmit: (event) => {
    event.preventDefault();
    send(typedNumber(input.value.trim()));
  } },
  setField.element,
  h("button", { type: "submit", class: "button primary" }, t("manual.set")),
  button(t("manual.zero"), () => {
    input.value = "0";
    send("0");
  }));
  return form;
}
