// One procedure as text: checked while it is typed, with the preview of its run and what is changed.

import { go, goToRig } from "../address.js";
import { get, personName, post } from "../client.js";
import { button, fill, h, setText, show } from "../dom.js";
import { draft, newDraft } from "../draft.js";
import { procedureEditor } from "../editor/editor.js";
import { localTime } from "../format.js";
import { changesBySection } from "../parts/changes.js";
import { askName, askText } from "../parts/dialogs.js";
import { forgetErrors, notify } from "../parts/notices.js";
import { planFacts } from "../parts/plan.js";
import { working } from "../parts/working.js";
import { person, attempt } from "../steer.js";
import { listen, store } from "../store.js";
import { translate, t } from "../texts.js";

const TYPING_MS = 400;
const UNSAVED_KEY = "rigrunner.text."; // the typed text that is not saved is stored in this tab

// For repeated requests: a failure is ignored.
function quietly(request) {
  return request.catch(() => null);
}

export function procedurePage(name) {
  const title = h("h1", {}, name);
  const state = h("p", { class: "soft", role: "status" });
  const notes = h("div", { class: "stack editor-notes" });
  const place = h("div", { class: "editor-place" });
  const station = h("select", { id: "procedure-station", onchange: () => stationChosen() });
  const problems = h("div", { class: "problems-box", role: "status" });
  const doing = h("div", { role: "status" });
  const plan = h("div", {});
  const changes = h("div", {}, h("p", { class: "soft" }, t("loading")));
  const save = button(t("procedure.save"), () => saveText(), { kind: "primary" });
  const approve = button(t("procedure.approve"), () => approveText());
  const copy = button(t("procedure.copy"), () => copyText());
  const test = button(t("procedure.test"), () => {
    newDraft({ procedure: name, station: station.value, inputs: {} });
    goToRig(station.value, "#/setup");
  });
  let editor = null;
  let opened = null; // as it is in the file
  let timer = 0;
  let requests = 0;
  let saving = false;
  let approvedUtc = null; // of the approval that is shown
  let following = ""; // digest of the file that is being read

  const isChanged = () => Boolean(opened) && editor.text() !== opened.text;

  async function load() {
    const [file, stations] = await Promise.all([attempt(() => get("procedures/text", { name })), attempt(() => get("stations"))]);
    if (!file || !stations) {
      fill(place, h("p", { class: "banner warn" }, t("procedure.gone")));
      return;
    }
    const usable = stations.items.filter((item) => !item.problem);
    const chosen = usable.find((item) => item.name === draft().station) ?? usable.find((item) => !item.shipped);
    fill(station, h("option", { value: "" }, t("procedure.no_station")), usable.map((item) => h("option", { value: item.name, selected: item === chosen }, translate(item.title) || item.name)));
    const unsaved = file.shipped ? null : JSON.parse(sessionStorage.getItem(UNSAVED_KEY + name));
    take(unsaved ? { ...file, digest: unsaved.digest } : file); // of the file that was changed here
    editor = procedureEditor(unsaved?.text ?? file.text, { readOnly: file.shipped, changed: later, save: saveText });
    fill(place, editor.element);
    if (unsaved && unsaved.text !== file.text) notify(t("procedure.restored"), { kind: "info" });
    await announceEditing();
    learn();
    update();
    look();
  }

  function take(file) {
    opened = file;
    const saved = t(file.changed_by ? "procedure.saved_by" : "procedure.saved_elsewhere", { name: file.changed_by, time: localTime(file.changed_utc) });
    if (file.shipped) fill(state, t("procedure.shipped"));
    else fill(state, translate(file.approval), file.approval && file.changed_utc ? " · " : "", file.changed_utc ? h("span", { class: "whole" }, saved) : "");
    const heading = /^title:\s*["']?(.*?)["']?\s*$/m.exec(file.text)?.[1];
    setText(title, translate(heading) || name);
  }

  // Shows others that this file is open here, if it can be changed.
  async function announceEditing() {
    if (!opened.shipped) await attempt(() => post("procedures/edit", { procedure: name, by: personName() }));
  }

  async function learn() {
    const schema = await attempt(() => get("procedures/schema", { station: station.value }));
    if (schema) editor.setSchema(schema);
  }

  function stationChosen() {
    learn();
    look();
  }

  function later() {
    if (isChanged()) sessionStorage.setItem(UNSAVED_KEY + name, JSON.stringify({ text: editor.text(), digest: opened.digest }));
    else sessionStorage.removeItem(UNSAVED_KEY + name);
    update();
    clearTimeout(timer);
    timer = setTimeout(look, TYPING_MS);
    outdated(true);
  }

  // The preview of an older text looks outdated until the next one.
  function outdated(is) {
    for (const part of [plan, changes]) part.setAttribute("aria-busy", String(is));
  }

  async function look() {
    const request = ++requests;
    const text = editor.text();
    const body = { procedure: name, text };
    const check = await working(doing, t("procedure.checking"), () => quietly(post("procedures/check", { ...body, station: station.value })));
    if (request !== requests || !check) return;
    editor.mark(check.problems);
    showProblems(check);
    if (!check.ok) {
      outdated(false);
      fill(plan, h("p", { class: "soft" }, t("procedure.not_while_wrong")));
      fill(changes, h("p", { class: "soft" }, t("procedure.not_while_wrong")));
      return;
    }
    const preview = station.value ? quietly(post("plan", { ...body, station: station.value })) : null;
    const comparison = quietly(post("procedures/compare", body));
    const [planned, compared] = await working(doing, t("procedure.previewing"), () => Promise.all([preview, comparison]));
    if (request !== requests) return;
    outdated(false);
    fill(plan, planned ? planFacts(planned) : h("p", { class: "soft" }, t("procedure.choose_station")));
    showChanges(compared);
  }

  function showProblems(check) {
    if (check.ok) {
      fill(problems, h("p", { class: "good-text" }, t(station.value ? "procedure.good_on" : "procedure.good")));
      return;
    }
    fill(problems, h("p", { class: "bad-text" }, t("procedure.problems", { count: check.problems.length })),
      h("ul", { class: "problems" }, check.problems.toSorted((a, b) => Boolean(a.file) - Boolean(b.file) || a.line - b.line).map((problem) => h("li", {},
        problem.line && !problem.file ? h("button", { type: "button", class: "link", onclick: () => editor.goTo(problem) }, t("procedure.line", { line: problem.line })) : h("span", { class: "where" }, [problem.file, problem.line].filter(Boolean).join(":")),
        problem.field ? h("span", { class: "where" }, problem.field) : null, h("span", {}, translate(problem.message)), problem.hint ? h("span", { class: "hint" }, translate(problem.hint)) : null))));
  }

  function showChanges(compared) {
    if (!compared) return fill(changes);
    const against = compared.run ? t(`procedure.against.${compared.against}`, { run: compared.run }) : t("procedure.against.nothing");
    fill(changes, h("p", { class: "soft" }, against),
      compared.run && compared.same ? h("p", {}, translate(compared.verdict)) : null,
      changesBySection(compared.changes).map(([heading, list]) => [h("h3", {}, heading), list]).flat());
  }

  async function saveText(digest = opened.digest) {
    if (opened.shipped || !isChanged() || saving) return;
    const by = await person(t("procedure.who"), t("procedure.save"));
    if (!by || saving) return;
    const text = editor.text();
    saving = true;
    try {
      const saved = await post("procedures/save", { procedure: name, text, digest, by });
      forgetErrors();
      await reopened(saved.digest, text);
      await announceEditing(); // now with a name
    } catch (error) {
      if (error.code === "changed") conflict();
      else notify(translate(error.message), { hint: translate(error.hint), problems: error.problems });
    } finally {
      saving = false;
    }
  }

  // What is in the file now, while the text in the editor stays.
  async function reopened(digest, text) {
    const file = await attempt(() => get("procedures/text", { name }));
    if (!file) return;
    take(file.digest === digest ? file : { ...file, digest, text });
    later();
    update();
  }

  async function approveText() {
    const by = await askName({ title: t("procedure.who_approves"), confirm: t("procedure.approve"), value: personName() });
    if (!by) return; // asked each time: it may be another person than the one who edits
    if (await attempt(() => post("procedures/approve", { procedure: name, sha256: opened.sha256, by }))) await reopened(opened.digest, opened.text);
  }

  async function copyText() {
    const file = await askText(t("procedure.copy"), t("procedure.copy_name"), { value: suggested(), confirm: t("procedure.copy_do") });
    const by = file && (await person(t("procedure.who"), t("procedure.copy_do")));
    if (!by) return;
    if (await attempt(() => post("procedures/save", { procedure: file, text: editor.text(), by }))) go(`#/procedures/${encodeURIComponent(file)}`);
  }

  function suggested() {
    return opened.shipped ? `${name}.yaml` : name.replace(/(\.ya?ml)$/, "_2$1");
  }

  // The file is not as it was opened: both texts are there, and a person says which one counts.
  function conflict() {
    const now = nowEdited();
    const who = now?.changed_by || t("procedure.another_program");
    fill(notes, h("section", { class: "banner warn" },
      h("div", {}, h("strong", {}, t("procedure.changed", { name: who, time: now ? localTime(now.changed_utc) : "" })), h("p", {}, t("procedure.changed_hint"))),
      h("div", { class: "row" },
        button(t("procedure.compare_theirs"), async () => {
          const compared = await attempt(() => post("procedures/compare", { procedure: name, text: editor.text(), against: "file" }));
          if (compared) fill(changes, h("p", { class: "soft" }, t("procedure.against.file")), compared.same ? h("p", {}, translate(compared.verdict)) : null, changesBySection(compared.changes).flat());
          changes.closest("details").open = true;
        }),
        button(t("procedure.take_theirs"), () => takeTheirs()),
        button(t("procedure.keep_mine"), async () => {
          const file = await quietly(get("procedures/text", { name }));
          await saveText(file?.digest ?? ""); // it may have been removed
        }, { kind: "danger" }))));
  }

  async function takeTheirs() {
    const file = await quietly(get("procedures/text", { name }));
    if (!file) return conflict();
    take(file);
    editor.replace(file.text);
    return update();
  }

  // Where nothing is typed that could be lost, the text that is in the file now is shown.
  async function follow({ digest, changed_by: who }) {
    if (following === digest) return;
    following = digest;
    await takeTheirs();
    if (opened.digest === digest) notify(t("procedure.followed", { name: who || t("procedure.another_program") }), { kind: "info" });
  }

  function nowEdited() {
    return store.state?.editing?.find((item) => item.procedure === name);
  }

  // Who else has it open, and whether the file is still as it was opened.
  function update() {
    if (!opened) return;
    const now = nowEdited();
    const stale = Boolean(now) && now.digest !== opened.digest;
    const others = (now?.editors ?? []).filter((other) => other.client !== store.state.you);
    if (!stale) fill(notes, others.map((other) => h("p", { class: "banner info" }, t("procedure.also", { name: other.name || t("procedure.somebody"), time: localTime(other.since_utc) }))));
    else if (!isChanged()) follow(now);
    else if (!notes.querySelector(".warn")) conflict();
    if (now && approvedUtc !== now.approved_utc) {
      const isNews = approvedUtc !== null;
      approvedUtc = now.approved_utc;
      if (isNews && !stale) reopened(opened.digest, opened.text);
    }
    save.disabled = !isChanged();
    approve.disabled = isChanged() || !opened.sha256 || opened.state === "approved";
    test.disabled = isChanged() || !opened.sha256;
    [save, approve].forEach((control) => show(control, !opened.shipped));
  }

  const forget = listen((changed) => {
    if (changed.has("editing") || changed.has("connected")) update();
  });
  load();
  return {
    title: t("nav.procedures"),
    element: h("div", { class: "page procedure" },
      h("div", { class: "head" }, h("div", {}, title, state), h("div", { class: "row" }, h("a", { class: "button", href: "#/procedures" }, t("procedure.back")), test, copy, approve, save)),
      notes,
      h("div", { class: "editor-columns" }, place,
        h("div", { class: "stack editor-side" },
          h("section", { class: "card" }, h("h2", {}, t("procedure.check")), h("div", { class: "field" }, h("label", { for: "procedure-station" }, t("procedure.on_station")), station), problems, doing),
          h("section", { class: "card" }, h("details", { open: true }, h("summary", {}, h("h2", {}, t("procedure.changes"))), changes)),
          h("section", { class: "card" }, h("details", {}, h("summary", {}, h("h2", {}, t("procedure.plan"))), plan))))),
    leave() {
      clearTimeout(timer);
      requests += 1;
      forget();
      editor?.leave();
      post("procedures/leave").catch(() => {});
    },
  };
}
