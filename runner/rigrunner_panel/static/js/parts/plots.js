// Which plots the operator wants: those of the page, and channels over time or over another. Kept per procedure.

import { button, fill, h, show } from "../dom.js";
import { channelChart } from "../plots/channel.js";
import { listen, store } from "../store.js";
import { t } from "../texts.js";

const KEPT = "rigrunner.plots.";
const MOST = 4;
const DRAW_MS = 100;

function keptFor(procedure) {
  try {
    const { hidden = [], added = [] } = JSON.parse(localStorage.getItem(KEPT + procedure)) ?? {};
    return { hidden, added };
  } catch {
    return { hidden: [], added: [] };
  }
}

// `own()` gives the page's plots as [key, title]; `changed()` is called when others are wanted.
export function plotChoice(own, changed) {
  let procedure = null;
  let kept = keptFor("");
  let charts = [];
  let known = "";
  const boxes = h("div", { class: "plot-boxes" });
  const y = h("select", { "aria-label": t("plots.y") });
  const x = h("select", { "aria-label": t("plots.x") });
  const add = button(t("plots.add"), () => keep({ ...kept, added: [...kept.added, [y.value, x.value]] }));
  const chooser = h("section", { class: "plot-chooser", role: "region", "aria-label": t("plots.title"), hidden: true }, boxes,
    h("div", { class: "plot-add" }, h("label", {}, t("plots.y"), y), h("label", {}, t("plots.x"), x), add));
  const element = h("div", { class: "chosen-plots", hidden: true });

  function keep(next) {
    kept = next;
    localStorage.setItem(KEPT + procedure, JSON.stringify(kept));
    arrange();
    changed();
  }

  function tick(key, title) {
    const box = h("input", { type: "checkbox", checked: !kept.hidden.includes(key), onchange: () => {
      keep({ ...kept, hidden: box.checked ? kept.hidden.filter((each) => each !== key) : [...kept.hidden, key] });
    } });
    return h("label", { class: "plot-box" }, box, title);
  }

  function arrange() {
    const channels = new Map((store.state?.channels ?? []).map((each) => [each.name, each]));
    const wanted = kept.added.filter(([one, other]) => channels.has(one) && (!other || channels.has(other))).slice(0, MOST);
    for (const each of charts) each.leave();
    charts = wanted.map(([one, other]) => channelChart(channels.get(one), other ? channels.get(other) : null));
    fill(element, charts.map((each) => each.element));
    show(element, charts.length > 0);
    const names = [...channels.keys()];
    const before = [y.value, x.value];
    fill(boxes, own().map(([key, title]) => tick(key, title)), kept.added.map((pair, i) => {
      const title = pair[1] ? t("plot.of_over", { y: pair[0], x: pair[1] }) : t("plot.channel", { channel: pair[0] });
      const drop = () => keep({ ...kept, added: kept.added.filter((_, at) => at !== i) });
      return button(t("plots.remove", { title }), drop, { kind: "small" });
    }));
    fill(y, names.map((name) => h("option", { value: name }, name)));
    fill(x, h("option", { value: "" }, t("plots.time")), names.map((name) => h("option", { value: name }, name)));
    if (names.includes(before[0])) [y.value, x.value] = before;
    add.disabled = !names.length || kept.added.length >= MOST;
    draw();
  }

  function draw() {
    for (const each of charts) each.show();
  }

  function take() {
    const { job, channels = [] } = store.state ?? {};
    const key = JSON.stringify([job?.procedure, own(), channels.map((each) => [each.name, each.unit])]);
    if (key === known) return;
    known = key;
    procedure = job?.procedure ?? "";
    kept = keptFor(procedure);
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
    wants: (key) => !kept.hidden.includes(key),
    leave() {
      forget();
      clearInterval(timer);
      for (const each of charts) each.leave();
    },
  };
}
