// Every channel of the rig: value, limits, age and a strip chart of the last minute. What is older than it
// should be looks old and says since when. Which strips are drawn is kept per procedure.

import { button, fill, h, setText, show } from "../dom.js";
import { clock, limitText, plain, UNKNOWN } from "../format.js";
import { pastOf, WINDOW_MS } from "../past.js";
import { listen, store } from "../store.js";
import { translate, t } from "../texts.js";
import { colour } from "../theme.js";

const LEAST_OLD_MS = 1000;
const DRAW_MS = 250;
const STORAGE_KEY = "rigrunner.strips.";

// How far the clock of the panel's machine is behind this one: by its time when the state was sent, or a newer value.
let behind = Infinity;

listen((changed) => {
  if (changed.has("now_utc")) behind = Math.min(behind, Date.now() - Date.parse(store.state.now_utc));
});

export function ageMs(utc) {
  return Date.now() - Date.parse(utc) - (Number.isFinite(behind) ? behind : 0);
}

export function ageText(utc) {
  return `${plain(Number((Math.max(ageMs(utc), 0) / 1000).toFixed(1)))} s`;
}

// Whether a value is older than it would be if it was still read, every so many seconds.
export function isOld(utc, intervalS = 0.1) {
  return !(ageMs(utc) < Math.max(LEAST_OLD_MS, 3000 * intervalS));
}

function hiddenFor(procedure) {
  try {
    return JSON.parse(localStorage.getItem(STORAGE_KEY + procedure)) ?? {};
  } catch {
    return {};
  }
}

export function channelList() {
  const body = h("tbody", {});
  const head = ["channels.name", "channels.value", "channels.limits", "channels.age", "channels.strip"];
  const element = h("section", { class: "channels", role: "region", tabindex: "0", "aria-label": t("channels.title"), hidden: true },
    h("table", {}, h("thead", {}, h("tr", {}, head.map((key) => h("th", { scope: "col" }, t(key))))), body));
  // Shows the channels in place of the plots that they are among.
  const watch = button(t("channels.title"), () => {
    show(element, element.hidden);
    element.parentElement.classList.toggle("of-channels", !element.hidden);
    watch.setAttribute("aria-pressed", String(!element.hidden));
  }, { kind: "big", "aria-pressed": "false" });
  let rows = [];
  let built = "";

  function build(channels, procedure) {
    const hidden = hiddenFor(procedure);
    rows = channels.map((channel) => {
      const value = h("strong", {}, UNKNOWN);
      const age = h("span", {});
      const canvas = h("canvas", { class: "strip", width: "300", height: "40", role: "img", "aria-label": t("channels.strip_of", { name: channel.name }) });
      const box = h("input", { type: "checkbox", checked: !hidden[channel.name], "aria-label": t("channels.show", { name: channel.name }), onchange: () => {
        const next = { ...hiddenFor(procedure), [channel.name]: !box.checked };
        localStorage.setItem(STORAGE_KEY + procedure, JSON.stringify(next));
        canvas.hidden = !box.checked;
      } });
      canvas.hidden = Boolean(hidden[channel.name]);
      const row = h("tr", {}, h("th", { scope: "row" }, translate(channel.long_name) || channel.name, h("span", { class: "soft block" }, channel.name)),
        h("td", { class: "number" }, value, ` ${channel.unit === "1" ? "" : channel.unit}`), h("td", { class: "number" }, limitText(channel)), h("td", { class: "age" }, age),
        h("td", {}, h("div", { class: "strip-cell" }, h("label", { class: "tick" }, box), canvas)));
      return { name: channel.name, row, value, age, canvas };
    });
    fill(body, rows.map((row) => row.row));
  }

  function take() {
    const { state } = store;
    const channels = state?.channels ?? [];
    const key = `${state?.job?.run}${channels.map((channel) => channel.name).join()}`;
    if (key !== built) {
      built = key;
      build(channels, state?.job?.procedure ?? "");
    }
    channels.forEach((channel, i) => {
      if (!channel.utc) return;
      const ms = Date.parse(channel.utc);
      behind = Math.min(behind, Date.now() - ms);
      setText(rows[i].value, plain(Number(channel.value.toPrecision(5))));
    });
  }

  function draw() {
    if (element.hidden) return;
    const channels = store.state?.channels ?? [];
    channels.forEach((channel, i) => {
      const row = rows[i];
      if (!row) return;
      const old = !channel.utc || isOld(channel.utc, channel.interval_s);
      row.row.classList.toggle("old", old);
      setText(row.age, !channel.utc ? UNKNOWN : old ? t("channels.since", { time: clock(channel.utc) }) : ageText(channel.utc));
      if (!row.canvas.hidden) strip(row.canvas, pastOf(channel.name));
    });
  }

  const forget = listen((changed) => {
    if (changed.has("channels") || changed.has("job")) take();
  });
  const timer = setInterval(draw, DRAW_MS);
  queueMicrotask(take);
  return {
    element,
    watch,
    leave() {
      forget();
      clearInterval(timer);
    },
  };
}

function strip(canvas, points) {
  const pen = canvas.getContext("2d");
  const { width, height } = canvas;
  pen.clearRect(0, 0, width, height);
  if (points.length < 2) return;
  const values = points.map(([, value]) => value);
  const low = Math.min(...values);
  const span = Math.max(...values) - low || 1;
  const end = Date.now() - (Number.isFinite(behind) ? behind : 0);
  pen.strokeStyle = colour("accent");
  pen.lineWidth = 2;
  pen.beginPath();
  points.forEach(([ms, value], i) => {
    const x = width * (1 - (end - ms) / WINDOW_MS);
    const y = height - 3 - (height - 6) * (value - low) / span;
    if (i) pen.lineTo(x, y);
    else pen.moveTo(x, y);
  });
  pen.stroke();
}
