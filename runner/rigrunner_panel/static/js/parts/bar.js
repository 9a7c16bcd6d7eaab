// The top of every page: where one is, the state of the rig, who has control, and Stop.

import { station } from "../address.js";
import { button, h, setText, show } from "../dom.js";
import { releaseControl, stopNow, takeControl, attempt } from "../steer.js";
import { hasControl, listen, store } from "../store.js";
import { chooseLanguage, languages, translate, t } from "../texts.js";
import { chooseTheme, themeNow } from "../theme.js";

const PAGES = [["#/", "nav.run"], ["#/queue", "nav.queue"], ["#/manual", "nav.manual"], ["#/procedures", "nav.procedures"], ["#/history", "nav.history"]];
const OF_PAGE = { "#/history": ["#/runs", "#/compare", "#/overlay", "#/trends"] };
const OF_NO_RIG = new Set(["#/history"]);
const BUSY = new Set(["checking", "starting", "running", "asking", "pausing", "paused", "ending", "analysing", "manual"]);

export function isBusy(state) {
  return Boolean(state) && BUSY.has(state.phase);
}

export function topBar() {
  const links = PAGES.filter(([href]) => station() || OF_NO_RIG.has(href)).map(([href, key]) => h("a", { href, class: "nav-link" }, t(key)));
  const count = h("span", { class: "nav-count", hidden: true });
  const rigs = h("a", { href: "/#/rigs", class: "nav-link", hidden: Boolean(station()) }, t("nav.rigs"), count);
  const name = h("span", { class: "rig-name", hidden: true });
  const phase = h("span", { class: "chip", role: "status" });
  const holder = h("span", { class: "holder" });
  const take = button(t("control.take"), () => attempt(() => takeControl()), { kind: "small" });
  const release = button(t("control.release"), () => releaseControl(), { kind: "small quiet" });
  const control = h("div", { class: "control" }, holder, take, release);
  const stop = h("button", { type: "button", class: "stop", onclick: () => stopNow(), "aria-keyshortcuts": "F9" },
    h("span", { class: "stop-word" }, t(station() ? "stop" : "stop.all")), h("kbd", { "aria-hidden": "true" }, "F9"));

  function update() {
    const { state, connected } = store;
    show(phase, Boolean(station()) || !connected);
    const key = connected && state ? `phase.${state.phase}` : "phase.disconnected";
    phase.className = `chip ${connected && state ? state.phase : "disconnected"}`;
    setText(phase, t(key));
    const current = state?.control;
    setText(holder, hasControl() ? t("control.you", { name: current.name }) : current ? t("control.other", { name: current.name }) : t("control.none"));
    show(control, Boolean(station()));
    show(take, !hasControl());
    show(release, hasControl());
    stop.classList.toggle("idle", !isBusy(state) && !store.rigs.some((rig) => !station() && isBusy(rig)));
  }

  // Of several rigs, which one this is, and how many of the others need somebody.
  function updateRigs() {
    const several = store.rigs.length > 1;
    show(rigs, several || !station());
    show(name, several && Boolean(station()));
    setText(name, translate(store.rigs.find((rig) => rig.station === station())?.title ?? ""));
    name.title = name.textContent; // a long one is cut off
    const waiting = store.rigs.filter((rig) => rig.station !== station() && (rig.waits_for || rig.alarms.length)).length;
    show(count, Boolean(station()) && waiting > 0);
    setText(count, String(waiting));
    count.setAttribute("aria-label", waiting === 1 ? t("nav.rig_waiting") : t("nav.rigs_waiting", { count: waiting }));
  }

  function mark() {
    const here = location.hash || "#/";
    if (!station() && (here === "#/" || here.startsWith("#/rigs"))) rigs.setAttribute("aria-current", "page");
    else rigs.removeAttribute("aria-current");
    const isAt = (page) => [page, ...(OF_PAGE[page] ?? [])].some((address) => here.startsWith(address));
    const isElsewhere = PAGES.some(([page]) => page !== "#/" && isAt(page));
    for (const link of links) {
      const target = link.getAttribute("href");
      if (target === "#/" ? !isElsewhere : isAt(target)) link.setAttribute("aria-current", "page");
      else link.removeAttribute("aria-current");
    }
  }

  listen((changed) => {
    if (changed.has("rigs")) updateRigs();
    if (["rigs", "phase", "control", "connected", "you"].some((name) => changed.has(name))) update();
  });
  window.addEventListener("hashchange", mark);
  update();
  mark();
  return h("header", { class: "bar" },
    h("a", { class: "brand", href: "#/" }, "Rigrunner"),
    h("nav", { "aria-label": t("nav.label") }, rigs, links),
    h("div", { class: "where" }, name, phase),
    control,
    h("div", { class: "choices" }, languageChoice(), themeChoice()),
    stop);
}

function languageChoice() {
  const { all, now } = languages();
  const select = h("select", { "aria-label": t("language"), class: "small-select", onchange: () => chooseLanguage(select.value) },
    all.map((code) => h("option", { value: code, selected: code === now }, code.toUpperCase())));
  return select;
}

function themeChoice() {
  const select = h("select", { "aria-label": t("theme"), class: "small-select", onchange: () => chooseTheme(select.value) },
    ["auto", "light", "dark"].map((name) => h("option", { value: name, selected: name === themeNow() }, t(`theme.${name}`))));
  return select;
}
