// The run as it is: state, steps, curves, numbers, and what can be done.

import { button, fill, h, setText, show } from "../dom.js";
import { channelList } from "../parts/channels.js";
import { alarmStrip } from "../parts/alarms.js";
import { askReason } from "../parts/dialogs.js";
import { abort, pauseOrResume } from "../parts/keys.js";
import { plotChoice } from "../parts/plots.js";
import { endedBanners } from "../parts/ended.js";
import { promptCard } from "../parts/prompt.js";
import { readouts } from "../parts/readouts.js";
import { liveResults } from "../parts/results.js";
import { stepList, stepWords } from "../parts/steps.js";
import { verdictLine } from "../parts/verdict.js";
import { latestCurve } from "../plots/curve.js";
import { resultCharts } from "../plots/results.js";
import { trendChart } from "../plots/trend.js";
import { steer } from "../steer.js";
import { listen, store } from "../store.js";
import { translate, t } from "../texts.js";

const STEERABLE = new Set(["running", "asking", "pausing", "paused"]);

export function runPage() {
  const curve = latestCurve();
  const trend = trendChart();
  const results = liveResults();
  const curves = resultCharts();
  const channels = channelList();
  const ofCurve = [["curve", t("plots.curve")], ["trend", t("plots.trend")], ["figures", t("plots.figures")]];
  const ofResults = [["trend", t("plots.trend")], ["results", t("plots.results")], ["figures", t("plots.figures")]];
  const pagePlots = () => (store.lastCurve ? ofCurve : ofResults);
  const chosen = plotChoice(pagePlots, () => store.state && arrange(store.state));
  const steps = stepList();
  const numbers = readouts();
  const alarms = alarmStrip();
  const prompt = promptCard();
  const verdict = verdictLine();
  const title = h("h1", {});
  const step = h("p", { class: "now", role: "status" });
  const paused = h("p", { class: "banner warn", hidden: true });
  const nothing = h("p", { class: "banner info", hidden: true }, t("run.nothing"), h("a", { class: "button", href: "#/" }, t("choose.title")));
  const over = h("div", { class: "stack", hidden: true });
  const pause = button(t("run.pause"), pauseOrResume, { kind: "big", key: "F8", "aria-keyshortcuts": "F8" });
  const repeat = button(t("run.repeat"), () => because("run/repeat", "run.repeat", { required: false }), { kind: "big" });
  const skip = button(t("run.skip"), () => because("run/skip", "run.skip", {}), { kind: "big" });
  const override = button(t("run.override"), () => because("run/override", "run.override", {}), { kind: "big" });
  const stopped = button(t("run.abort"), abort, { kind: "big danger" });
  const choose = button(t("plots.title"), () => {
    show(chosen.chooser, chosen.chooser.hidden);
    choose.setAttribute("aria-pressed", String(!chosen.chooser.hidden));
  }, { kind: "big", "aria-pressed": "false" });
  const plots = h("div", { class: "run-plots", role: "group", tabindex: "0", "aria-label": t("plots.all") }, channels.element, curve.element, results.element, curves.element, trend.element, chosen.element);
  const element = h("div", { class: "page run" },
    h("aside", { class: "run-side" }, steps.element),
    h("div", { class: "run-head" }, h("div", {}, title, step), verdict.element),
    numbers.element,
    plots,
    h("div", { class: "run-foot" }, alarms.element, paused, nothing, over, chosen.chooser, h("div", { class: "run-buttons" }, pause, repeat, skip, override, channels.watch, choose, stopped)),
    prompt.element);

  async function because(path, key, options) {
    const reason = await askReason(t(`${key}.title`), { confirm: t(key), ...options });
    if (reason !== null) await steer(path, { reason });
  }

  function update(changed) {
    const { state } = store;
    if (!state) return;
    const can = STEERABLE.has(state.phase);
    setText(title, [translate(state.job?.title), state.job?.inputs.specimen].filter(Boolean).join(" · "));
    setText(step, stepText(state));
    show(nothing, state.phase === "idle" || state.phase === "checking");
    for (const control of [pause, stopped]) control.disabled = !can;
    const choices = state.pause?.choices;
    repeat.disabled = !can || Boolean(choices && !choices.includes("repeat"));
    skip.disabled = !can || Boolean(choices && !choices.includes("skip"));
    show(override, Boolean(state.pause?.choices.includes("override")));
    setText(pause.firstChild, state.phase === "paused" ? t("run.resume") : t("run.pause"));
    if (changed.has("phase") || changed.has("finished")) showOver(state);
    show(paused, Boolean(state.pause));
    if (state.pause) fill(paused, h("strong", {}, t("run.paused")), h("span", {}, [state.pause.reason, ...(state.pause.moving.length ? state.pause.moving : [t("run.standing")])].filter(Boolean).map(translate).join(" · ")));
    if (changed.has("live") || changed.has("plan") || changed.has("progress")) arrange(state);
    steps.update(changed);
    numbers.update();
    alarms.update();
    prompt.update();
    verdict.update();
  }

  // Nothing on this page is of now any more: it says so, and why.
  function showOver({ phase, job, finished }) {
    const isOver = phase === "finished" && job?.kind === "run";
    show(over, isOver);
    if (!isOver) return;
    const see = finished?.run ? h("a", { class: "button", href: `#/runs/${encodeURIComponent(finished.run)}` }, t("run.see")) : null;
    const banners = endedBanners(finished?.error, { isNow: true, hint: finished?.hint }).filter(Boolean);
    if (!banners.length) banners.push(h("p", { class: "banner info" }, h("span", {}, t("run.over"))));
    if (see) banners.at(-1).append(see);
    fill(over, banners);
  }

  // Where no analysis shows curves there is the table of results; a plot of nothing is not shown.
  function arrange(state) {
    const isCurve = Boolean(store.lastCurve);
    plots.classList.toggle("of-results", !isCurve);
    plots.classList.toggle("of-chosen", !chosen.element.hidden);
    show(curve.element, isCurve && chosen.wants("curve"));
    show(results.element, !isCurve && chosen.wants("results"));
    show(curves.element, chosen.wants("figures"));
    show(trend.element, store.trend.minimum.length > 0 && chosen.wants("trend"));
    results.show(state.live?.results ?? []);
    curves.show((state.live?.figures ?? []).slice(isCurve ? -1 : 0));
  }

  function showCurve() {
    curve.show(store.lastCurve, store.state?.progress?.recording);
    chosen.take();
  }

  const forget = listen((changed) => {
    if (changed.has("curve") || changed.has("progress")) showCurve();
    if (changed.has("trend")) {
      trend.show(store.trend);
      if (store.state) arrange(store.state);
    }
    if (changed.size > 1 || !(changed.has("curve") || changed.has("trend"))) update(changed);
  });
  const aging = setInterval(() => {
    if (store.state) numbers.update();
    if (store.lastCurve) showCurve();
  }, 500);
  queueMicrotask(() => {
    chosen.take();
    update(new Set(["live", "phase", "plan", "progress"]));
    showCurve();
    trend.show(store.trend);
  });
  return {
    title: t("run.title"),
    element,
    leave() {
      forget();
      clearInterval(aging);
      for (const part of [curve, trend, curves, channels, chosen]) part.leave();
    },
  };
}

function stepText(state) {
  if (state.phase === "finished") return t("phase.finished");
  if (state.phase === "analysing" && state.analysing) return t("run.analysing", { done: state.analysing.done, of: state.analysing.of });
  if (state.asked && STEERABLE.has(state.phase)) return t(`run.asked.${state.asked}`);
  const index = state.progress?.index ?? -1;
  const step = state.plan?.steps.find((item) => item.index === index);
  return step ? `${index + 1}/${state.plan.steps.length}  ${stepWords(step)}` : t(`phase.${state.phase}`);
}
