// What is different between two runs.

import { get } from "../client.js";
import { fill, h } from "../dom.js";
import { changesBySection } from "../parts/changes.js";
import { working } from "../parts/working.js";
import { attempt } from "../steer.js";
import { translate, t } from "../texts.js";

export function comparePage(before, after) {
  const body = h("div", { role: "status" });

  async function load() {
    const comparison = await working(body, t("loading"), () => attempt(() => get("compare", { before, after })));
    if (!comparison) return fill(body, h("p", { class: "banner warn" }, t("compare.failed")));
    return fill(body,
      h("p", { class: `banner ${comparison.same ? "info" : "warn"}` }, translate(comparison.verdict) || t(comparison.same ? "compare.same" : "compare.different")),
      comparison.changes.some((change) => change.section === "results") ? null : h("p", { class: "good-text" }, t("compare.same_results")),
      changesBySection(comparison.changes).map(([heading, list]) => h("section", { class: "card" }, h("h2", {}, heading), list)));
  }

  load();
  const link = (run) => h("a", { href: `#/runs/${encodeURIComponent(run)}` }, run);
  return {
    title: t("compare.title"),
    element: h("div", { class: "page compare" }, h("h1", {}, t("compare.title")),
      h("dl", { class: "facts" }, h("dt", {}, t("compare.before")), h("dd", {}, link(before ?? "")), h("dt", {}, t("compare.after")), h("dd", {}, link(after ?? ""))), body),
  };
}
