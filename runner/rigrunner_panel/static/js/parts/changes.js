// Differences as sentences, by section: [heading, list] of each.

import { h } from "../dom.js";
import { has, translate, t } from "../texts.js";

// A section is called as in the file of the procedure or station, but for these.
function sectionWords(section) {
  const key = `compare.section.${section.replaceAll(" ", "_")}`;
  return has(key) ? t(key) : translate(section);
}

export function changesBySection(changes) {
  const sections = [...new Set(changes.map((change) => change.section))];
  return sections.map((section) => [sectionWords(section), h("ul", { class: "changes" }, changes.filter((change) => change.section === section).map(row))]);
}

function row(change) {
  return h("li", { class: change.matters ? "matters" : "" }, change.matters ? h("span", { class: "mark warn" }, t("compare.matters")) : null, h("span", {}, translate(change.text)));
}
