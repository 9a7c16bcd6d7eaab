// What is different between two runs.

import { get } from "../client.js";
import { fill, h } from "../dom.js";
import { tried } from "../steer.js";
import { has, said, t } from "../texts.js";

// A section is called as in the file of the procedure or station, but for these.
function sectionWords(section) {
  const key = `compare.section.${section.replaceAll(" ", "_")}`;
  return has(key) ? t(key) : said(section);
}

export function comparePage(before, after) {
  const body = h("div", {}, h("p", { class: "soft" }, t("loading")));

  async function load() {
    const found = await tried(() => get("compare", { before, after }));
    if (!found) return fill(body, h("p", { class: "banner warn" }, t("compare.failed")));
    const sections = [...new Set(found.changes.map((change) => change.section))];
    return fill(body,
      h("p", { class: `banner ${found.same ? "info" : "warn"}` }, said(found.verdict) || t(found.same ? "compare.same" : "compare.different")),
      sections.map((section) => h("section", { class: "card" }, h("h2", {}, sectionWords(section)),
        h("ul", { class: "changes" }, found.changes.filter((change) => change.section === section).map((change) =>
          h("li", { class: change.matters ? "matters" : "" }, change.matters ? h("span", { class: "mark warn" }, t("compare.matters")) : null, h("span", {}, said(change.text))))))));
  }

  load();
  const link = (run) => h("a", { href: `#/runs/${encodeURIComponent(run)}` }, run);
  return {
    title: t("compare.title"),
    element: h("div", { class: "page compare" }, h("h1", {}, t("compare.title")),
      h("dl", { class: "facts" }, h("dt", {}, t("compare.before")), h("dd", {}, link(before ?? "")), h("dt", {}, t("compare.after")), h("dd", {}, link(after ?? ""))), body),
  };
}
