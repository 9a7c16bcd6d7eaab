// Which plots the operator wants: those of the page, and channels over time or over another. Kept per procedure.

import { button, fill, h, show } from "../dom.js";
import { channelChart } from "../plots/channel.js";
import { listen, store } from "../store.js";
import { t } from "../texts.js";

const STORAGE_KEY = "rigrunner.plots.";
const MOST = 4;
const DRAW_MS = 100;

function storedFor(procedure) {
  try {
    const { hidden = [], added = [] } = JSON.parse(localStorage.getItem(STORAGE_KEY + procedure)) ?? {};
    return { hidden, added };
  } catch {
    return { hidden: [], added: [] };
  }
}

// `own()` gives the page's plots as [key, title]; `changed()` is called when others are wanted.
export function plotChoice(pagePlots, changed) {
  let procedure = null;
  let choice = storedFor("");
  let charts = [];
  let shownKey = "";
  const boxes = h("div", { class: "plot-boxes" });
  const y = h("select", { "aria-label": t("plots.y") });
  const x = h("select", { "aria-label": t("plots.x") });
  const add = button(t("plots.add"), () => keep({ ...choice, added: [...choice.added, [y.value, x.value]] }));
  const chooser = h("section", { class: "plot-chooser", role: "region", "aria-label": t("plots.title"), hidden: true }, boxes,
    h("div", { class: "plot-add" }, h("label", {}, t("plots.y"), y), h("label", {}, t("plots.x"), x), add));
  const element = h("div", { class: "chosen-plots", hidden: true });

  function keep(next) {
    choice = next;
    localStorage.setItem(STORAGE_KEY + procedure, JSON.stringify(choice));
    arrange();
    changed();
  }

  function tick(key, title) {
    const box = h("input", { type: "checkbox", checked: !choice.hidden.includes(key), onchange: () => {
      keep({ ...choice, hidden: box.checked ? choice.hidden.filter((name) => name !== key) : [...choice.hidden, key] });
    } });
    return h("label", { class: "plot-box" }, box, title);
  }

  function arrange() {
    const channels = new Map((store.state?.channels ?? []).map((channel) => [channel.name, channel]));
    const pairs = choice.added.filter(([yName, xName]) => channels.has(yName) && (!xName || channels.has(xName))).slice(0, MOST);
    for (const chart of charts) chart.leave();
    charts = pairs.map(([yName, xName]) => channelChart(channels.get(yName), xName ? channels.get(xName) : null));
    fill(element, charts.map((chart) => chart.element));
    show(element, charts.length > 0);
    const names = [...channels.keys()];
    const before = [y.value, x.value];
    fill(boxes, pagePlots().map(([key, title]) => tick(key, title)), choice.added.map((pair, i) => {
      const title = pair[1] ? t("plot.of_over", { y: pair[0], x: pair[1] }) : t("plot.channel", { channel: pair[0] });
      const drop = () => keep({ ...choice, added: choice.added.filter((_, index) => index !== i) });
      return button(t("plots.remove", { title }), drop, { kind: "small" });
    }));
    fill(y, names.map((name) => h("option", { value: name }, name)));
    fill(x, h("option", { value: "" }, t("plots.time")), names.map((name) => h("option", { value: name }, name)));
    if (names.includes(before[0])) [y.value, x.value] = before;
    add.disabled = !names.length || choice.added.length >= MOST;
    draw();
  }

  function draw() {
    for (const chart of charts) chart.show();
  }

  function take() {
    const { job, channels = [] } = store.state ?? {};
    const key = JSON.stringify([job?.procedure, pagePlots(), channels.map((channel) => [channel.name, channel.unit])]);
    if (key === shownKey) return;
    shownKey = key;
    procedure = job?.procedure ?? "";
    choice = storedFor(procedure);
    arrange();
    changed();
  }

  const forget = listen((sections) => {
    if (["channels", "job", "plan", "live"].some((name) => sections.has(name))) take();
  });
  const timer = setInterval(draw, DRAW_MS);
  return {
    element,
    chooser,
    take,
    wants: (key) => !choice.hidden.includes(key),
    leave() {
      forget();
      clearInterval(timer);
      for (const chart of charts) chart.leave();
    },
  };
}
