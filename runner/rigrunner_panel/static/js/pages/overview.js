// All rigs on one screen, to be read across the room. Each has its STOP.

import { rigAddress } from "../address.js";
import { fill, h, setText, show } from "../dom.js";
import { duration } from "../format.js";
import { isBusy } from "../parts/bar.js";
import { stepWords } from "../parts/steps.js";
import { SIGNS, verdictText } from "../parts/verdict.js";
import { stopNow } from "../steer.js";
import { listen, store } from "../store.js";
import { translate, t } from "../texts.js";

export function overviewPage() {
  const grid = h("div", { class: "rigs" });
  const nothing = h("p", { class: "banner info", hidden: true }, t("rigs.nothing"), h("a", { class: "button", href: "#/choose" }, t("choose.title")));
  const cards = new Map();

  function update() {
    const names = store.rigs.map((rig) => rig.station);
    if (names.join("\n") !== [...cards.keys()].join("\n")) {
      cards.clear();
      for (const rig of store.rigs) cards.set(rig.station, rigCard(rig));
      fill(grid, [...cards.values()].map((card) => card.element));
    }
    for (const rig of store.rigs) cards.get(rig.station).update(rig);
    grid.classList.toggle("many", names.length > 4);
    show(nothing, store.connected && names.length === 0);
  }

  const forget = listen((changed) => {
    if (changed.has("rigs") || changed.has("connected")) update();
  });
  queueMicrotask(update);
  return {
    title: t("rigs.title"),
    element: h("div", { class: "page overview" }, h("h1", { class: "visually-hidden" }, t("rigs.title")), nothing, grid),
    leave: forget,
  };
}

function rigCard({ station }) {
  const name = h("a", { class: "rig-title", href: rigAddress(station) });
  const stop = h("button", { type: "button", class: "stop", onclick: () => stopNow(station) }, h("span", { class: "stop-word" }, t("stop")));
  const word = h("p", { class: "rig-word", role: "status" });
  const specimen = h("p", { class: "rig-specimen" });
  const procedure = h("p", { class: "rig-procedure" });
  const step = h("p", { class: "rig-step" });
  const bar = h("progress", { max: "1", value: "0", "aria-label": t("steps.progress") });
  const left = h("span", { class: "rig-left" });
  const progress = h("div", { class: "rig-progress" }, bar, left);
  const alarm = h("p", { class: "banner bad", role: "alert", hidden: true });
  const waits = h("p", { class: "banner warn", hidden: true });
  const foot = h("p", { class: "rig-foot" });
  const element = h("section", {}, h("div", { class: "rig-head" }, h("h2", {}, name), stop),
    word, alarm, waits, h("div", { class: "rig-body" }, specimen, procedure, step, progress), foot);

  function update(rig) {
    const busy = isBusy(rig) && rig.phase !== "checking";
    const { kind, text } = stateOf(rig);
    element.className = `rig ${kind}`;
    setText(name, translate(rig.title));
    stop.setAttribute("aria-label", t("rigs.stop", { name: translate(rig.title) }));
    stop.classList.toggle("idle", !isBusy(rig));
    setText(word, text);
    setText(specimen, rig.specimen || (rig.kind && rig.kind !== "preflight" ? t("rigs.no_specimen") : ""));
    setText(procedure, rig.kind === "preflight" ? "" : rig.procedure);
    setText(step, busy && rig.step && rig.phase !== "asking" ? `${rig.number}/${rig.steps}  ${stepWords(rig.step)}` : "");
    show(progress, busy && rig.steps > 0);
    const total = rig.done_s + rig.left_s;
    bar.value = total ? rig.done_s / total : 0;
    setText(left, t("rigs.left", { time: duration(rig.left_s) }));
    show(alarm, rig.alarms.length > 0);
    setText(alarm, rig.alarms.map(translate).join(" · "));
    const reason = rig.problem || rig.waits_for || (busy ? "" : rig.reason);
    show(waits, Boolean(reason) && !rig.alarms.includes(reason)); // an alarm says it already
    setText(waits, translate(reason));
    const next = rig.next ? t("rigs.next", { name: rig.next, count: rig.waiting }) : rig.waiting ? t("queue.waiting", { count: rig.waiting }) : t("rigs.queue_empty");
    setText(foot, [next, rig.automatic_by ? t("rigs.automatic") : "", rig.control ? t("control.other", { name: rig.control }) : t("control.none")].filter(Boolean).join(" · "));
  }

  return { element, update };
}

// The state in one word or two, and of what kind it is: by the verdict once a run is over.
function stateOf(rig) {
  if (rig.problem) return { kind: "broken", text: t("choose.broken") };
  if (rig.phase !== "finished" || rig.kind !== "run") return { kind: rig.alarms.length ? "alarm" : rig.phase, text: t(`phase.${rig.phase}`) };
  const verdict = rig.verdict ? `${SIGNS[rig.verdict] ?? "~"} ${verdictText(rig.verdict)}` : "";
  const concluded = rig.outcome === "completed" || rig.outcome === "stopped at a limit";
  const kind = rig.alarms.length || !concluded ? "alarm" : rig.verdict.replaceAll(" ", "-") || "finished";
  return { kind, text: concluded && verdict ? verdict : t(`outcome.${rig.outcome || "unknown"}`) };
}
