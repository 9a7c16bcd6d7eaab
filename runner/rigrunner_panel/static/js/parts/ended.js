// Why a run ended. That the rig is not safe stands by itself, in red, and says what to do.

import { h } from "../dom.js";
import { translate, t } from "../texts.js";

const UNSAFE = /^(.*?)(?:; |^)the rig is not safe: (.+)$/s; // as the engine words it

// `isNow` says that it is the panel's last run; since an older one the rig may have been made safe.
export function endedBanners(why, { isNow, hint = "" }) {
  if (!why) return [];
  const [, first, unsafe] = UNSAFE.exec(why) ?? [null, why, ""];
  return [
    unsafe ? h("p", { class: "banner bad wide", role: "alert" }, h("strong", {}, t(isNow ? "ended.unsafe" : "ended.was_unsafe")), h("span", {}, translate(unsafe))) : null,
    first ? h("div", { class: "banner warn wide" }, h("span", {}, translate(first)), hint ? h("span", {}, translate(hint)) : null) : null,
  ];
}
