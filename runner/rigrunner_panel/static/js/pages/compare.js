// What is different between two runs.

import { get } from "../client.js";
import { fill, h } from "../dom.js";
import { changesBySection } from "../parts/changes.js";
import { working } from "../parts/working.js";
import { tried } from "../steer.js";
import { said, t } from "../texts.js";

export function comparePage(before, after) {
  const body = h("div", { role: "status" });

  async function load() {
    const found = await working(body, t("loading"), () => tried(() => get("compare", { before, after })));
    if (!found) return fill(body, h("p", { class: "banner warn" }, t("compare.failed")));
    return fill(body,
      h("p", { class: `banner ${found.same ? "info" : "warn"}` }, said(found.verdict) || t(found.same ? "compare.same" : "compare.different")),
      found.changes.some((change) => change.section === "results") ? null : h("p", { class: "good-text" }, t("compare.same_results")),
      changesBySection(found.changes).map(([heading, list]) => h("section", { class: "card" }, h("h2", {}, heading), list)));
  }

  load();
  const link = (run) => h("a", { href: `#/runs/${encodeURIComponent(run)}` }, run);
  return {
    title: t("compare.title"),
    element: h("div", { class: "page compare" }, h("h1", {}, t("compare.title")),
      h("dl", { class: "facts" }, h("dt", {}, t("compare.before")), h("dd", {}, link(before ?? "")), h("dt", {}, t("compare.after")), h("dd", {}, link(after ?? ""))), body),
  };
}
