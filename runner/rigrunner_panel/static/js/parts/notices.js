// What the person has to know now: errors of requests, shown until they are put away.

import { button, h } from "../dom.js";
import { said, t } from "../texts.js";

const list = h("div", { class: "notices", role: "alert" });
const LONGEST_MS = 15000;

export function noticesElement() {
  return list;
}

export function tell(message, { hint = "", problems = [], kind = "error" } = {}) {
  const note = h(
    "section",
    { class: `notice ${kind}` },
    h("div", { class: "notice-text" }, h("strong", {}, message), hint ? h("p", {}, hint) : null, problemList(problems)),
    button(t("notice.close"), () => note.remove(), { kind: "quiet" }),
  );
  list.append(note);
  if (kind !== "error") setTimeout(() => note.remove(), LONGEST_MS);
  while (list.children.length > 3) list.firstChild.remove();
}

// Puts away what was refused: something else worked since.
export function forgetErrors() {
  for (const each of list.querySelectorAll(".notice.error")) each.remove();
}

export function tellError(error) {
  if (error.code === "no_connection") tell(t("error.no_connection"), { hint: t("error.no_connection.hint") });
  else tell(said(error.message), { hint: said(error.hint), problems: error.problems });
}

// Why something was refused in one line, as it stands beside a field.
export function refusedWords(error) {
  if (error.code === "no_connection") return t("error.no_connection");
  return [error.message, error.hint].filter(Boolean).map(said).join(" \u00b7 ");
}

// A line of the list that was typed or pasted, which is not a file.
function place(where) {
  return where?.replace(/^list:(\d+)$/, (_, line) => t("procedure.line", { line }));
}

export function problemList(problems) {
  if (!problems.length) return null;
  const item = (problem) =>
    h(
      "li",
      {},
      h("span", { class: "where" }, [place(problem.where), problem.field].filter(Boolean).join(" ")),
      h("span", {}, said(problem.message)),
      problem.hint ? h("span", { class: "hint" }, said(problem.hint)) : null,
    );
  return h("ul", { class: "problems" }, problems.map(item));
}
