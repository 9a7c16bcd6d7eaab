// The newest alarm, those that last in front; all of them on a click.

import { fill, h, setText, show } from "../dom.js";
import { localTime } from "../format.js";
import { store } from "../store.js";
import { translate, t } from "../texts.js";

export function alarmStrip() {
  const first = h("span", { class: "alarm-text" });
  const list = h("ul", { class: "alarm-list" });
  const summary = h("summary", {}, h("span", { class: "sign", "aria-hidden": "true" }, "!"), first);
  const element = h("details", { class: "alarms", role: "alert", hidden: true }, summary, list);
  let shown = null;
  return {
    element,
    update() {
      const { alarms } = store.state;
      if (alarms === shown) return;
      shown = alarms;
      show(element, alarms.length > 0);
      if (!alarms.length) return;
      const newest = [...alarms].reverse();
      const top = newest.find((alarm) => alarm.active) ?? newest[0];
      element.classList.toggle("active", top.active);
      const words = [top.utc ? localTime(top.utc) : "", translate(top.text)].filter(Boolean).join(" · ");
      setText(first, alarms.length > 1 ? t("alarms.many", { text: words, count: alarms.length }) : words);
      fill(list, newest.map((alarm) => h("li", { class: alarm.active ? "active" : "" }, h("time", {}, localTime(alarm.utc)), h("span", {}, translate(alarm.text)))));
    },
  };
}
