// Across the page while there is no connection: what is seen may be old, and stop does not get through.

import { h, show } from "../dom.js";
import { listen, store } from "../store.js";
import { t } from "../texts.js";

export function lostBanner() {
  const element = h("p", { class: "banner lost", role: "alert", hidden: true }, t("lost"));
  listen((changed) => {
    if (changed.has("connected")) show(element, !store.connected);
  });
  return element;
}
