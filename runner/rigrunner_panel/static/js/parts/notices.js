// Notices, such as errors of requests, shown until they are closed.

import { button, h } from "../dom.js";
import { translate, t } from "../texts.js";

const list = h("div", { class: "notices", role: "alert" });
const LONGEST_MS = 15000;

export function noticesElement() {
  return list;
}

export function notify(message, { hint = "", problems = [], kind = "error" } = {}) {
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

// Closes the errors of earlier requests, after one that succeeded.
export function forgetErrors() {
  for (const notice of list.querySelectorAll(".notice.error")) notice.remove();
}

export function notifyError(error) {
  if (error.code === "no_connection") notify(t("error.no_connection"), { hint: t("error.no_connection.hint") });
  else notify(translate(error.message), { hint: translate(error.hint), problems: error.problems });
}

// Why something was refused in one line, as it stands beside a field.
export function refusedWords(error) {
  if (error.code === "no_connection") return t("error.no_connection");
  return [error.message, error.hint].filter(Boolean).map(translate).join(" \u00b7 ");
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
      h("span", {}, translate(problem.message)),
      problem.hint ? h("span", { class: "hint" }, translate(problem.hint)) : null,
    );
  return h("ul", { class: "problems" }, problems.map(item));
}
