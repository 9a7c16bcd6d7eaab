// The queue: specimens scanned, typed or from a list; their order, and the start of the next one.

import { go, goToRig, station as ofWindow } from "../address.js";
import { get, personName, post } from "../client.js";
import { breakable, button, fill, h, setText, show } from "../dom.js";
import { draft, keepDraft, newDraft } from "../draft.js";
import { typedList, UNKNOWN } from "../format.js";
import { isBusy } from "../parts/bar.js";
import { askReason } from "../parts/dialogs.js";
import { inputForm } from "../parts/inputs.js";
import { problemList, refusedWords } from "../parts/notices.js";
import { isField, takeScans } from "../parts/scanner.js";
import { working } from "../parts/working.js";
import { verdictText } from "../parts/verdict.js";
import { steer, steerOrRefuse, attempt } from "../steer.js";
import { listen, store } from "../store.js";
import { translate, t } from "../texts.js";
import { titlesOf } from "../titles.js";

const SPECIMEN = "specimen";
const MOST_BYTES = 60000; // of a list in one request
const MOVABLE = new Set(["proposed", "waiting", "held"]);
const OVER = new Set(["done", "skipped", "closed"]);

export function queuePage() {
  const next = button(t("queue.start_next"), () => steer("queue/start", {}), { kind: "primary big" });
  const clear = button(t("queue.clear"), () => steer("queue/clear"), { kind: "big" });
  const automatic = h("input", { type: "checkbox", id: "queue-automatic", onchange: () => steer("queue/automatic", { on: automatic.checked }).then(update) });
  const now = h("p", { class: "queue-now", role: "status" });
  const problem = h("p", { class: "banner warn", role: "alert", hidden: true });
  const rows = h("tbody", {});
  const nothing = h("p", { class: "nothing" }, t("queue.nothing"));
  const left = h("p", { class: "soft", hidden: true });
  const adding = addCard();
  const head = ["queue.entry", "history.specimen", "queue.status"];
  const table = h("table", { class: "queue-table" },
    h("thead", {}, h("tr", {}, head.map((key) => h("th", { scope: "col" }, t(key))), h("th", { scope: "col" }, h("span", { class: "visually-hidden" }, t("queue.actions"))))), rows);
  let shown = "";
  let titles = new Map();

  function update() {
    const { state } = store;
    if (!state) return;
    const { queue } = state;
    const waiting = queue.entries.filter((entry) => entry.status === "waiting").length;
    const upNext = queue.entries.find((entry) => entry.id === queue.next);
    const hasInterrupted = queue.entries.some((entry) => entry.status === "interrupted");
    next.disabled = !upNext || isBusy(state) || queue.starting !== null;
    setText(next.firstChild, upNext ? t("queue.start_named", { name: named(upNext) }) : t("queue.start_next"));
    clear.disabled = !queue.entries.some((entry) => OVER.has(entry.status));
    automatic.checked = Boolean(queue.automatic_by);
    const present = queue.entries.find((entry) => entry.id === queue.starting || entry.status === "running");
    const text = queue.starting !== null && present ? t("queue.checking", { name: named(present) }) : present ? t("queue.running", { name: named(present) }) : hasInterrupted ? t("queue.asks") : t("queue.waiting", { count: waiting });
    setText(now, queue.automatic_by ? `${text} · ${t("queue.automatic_by", { name: queue.automatic_by })}` : text);
    show(problem, Boolean(queue.problem));
    if (queue.problem) setText(problem, translate(queue.problem));
    show(nothing, queue.entries.length === 0);
    show(table, queue.entries.length > 0);
    show(left, queue.left_out > 0);
    if (queue.left_out) setText(left, t("queue.left_out", { count: queue.left_out }));
    const newest = JSON.stringify([queue.entries, queue.next]);
    if (newest === shown) return;
    shown = newest;
    const focused = document.activeElement?.id;
    fill(rows, queue.entries.map((entry, i) => row(entry, i, queue, titles)));
    if (focused?.startsWith("queue-")) refocus(document.getElementById(focused));
  }

  const forget = listen((changed) => {
    if (changed.has("queue") || changed.has("phase")) update();
  });
  queueMicrotask(update);
  titlesOf("procedures").then((loaded) => {
    titles = loaded;
    shown = "";
    update();
  });
  return {
    title: t("queue.title"),
    element: h("div", { class: "page queue" },
      h("div", { class: "head" }, h("div", {}, h("h1", {}, t("queue.title")), now),
        h("div", { class: "row" },
          h("label", { class: "check", for: "queue-automatic" }, automatic, h("span", {}, t("queue.automatic"))), clear, next)),
      problem,
      h("div", { class: "queue-columns" }, adding,
        h("section", { class: "card queue-card" }, h("div", { class: "queue-scroll", tabindex: "0", role: "region", "aria-label": t("queue.title") }, table, nothing, left)))),
    leave() {
      forget();
      takeScans(null);
    },
  };
}

// At either end there is no way further: the other button of the row is next.
function refocus(element) {
  (element?.disabled ? element.parentElement.querySelector("button:enabled") : element)?.focus();
}

function named(entry) {
  return entry.specimen || entry.procedure;
}

function row(entry, i, { entries, next }, titles) {
  const before = entries.slice(0, i).findLast((other) => MOVABLE.has(other.status));
  const later = entries.slice(i + 1).filter((other) => MOVABLE.has(other.status));
  const can = MOVABLE.has(entry.status);
  const small = (name, text, work, more = {}) => button(text, work, { kind: "small", id: `queue-${name}-${entry.id}`, ...more });
  const because = async (path, title, confirm) => {
    const reason = await askReason(title, { confirm });
    if (reason) await steer(path, { entry: entry.id, reason });
  };
  const buttons = [
    can ? small("up", "↑", () => steer("queue/move", { entry: entry.id, before: before.id }), { disabled: !before, "aria-label": t("queue.up", { name: named(entry) }) }) : null,
    can ? small("down", "↓", () => steer("queue/move", { entry: entry.id, before: later[1]?.id ?? null }), { disabled: !later.length, "aria-label": t("queue.down", { name: named(entry) }) }) : null,
    entry.status === "waiting" ? small("open", t("queue.open"), () => open(entry)) : null,
    entry.status === "waiting" ? small("hold", t("queue.hold"), () => because("queue/hold", t("queue.hold.title", { name: named(entry) }), t("queue.hold"))) : null,
    entry.status === "proposed" || entry.status === "held" ? small("release", t("queue.release"), () => steer("queue/release", { entry: entry.id }), { kind: "small primary" }) : null,
    can || entry.status === "interrupted" ? small("skip", t(can ? "queue.skip" : "queue.close"), () => because("queue/skip", t("queue.skip.title", { name: named(entry) }), t(can ? "queue.skip" : "queue.close"))) : null,
    OVER.has(entry.status) || entry.status === "interrupted" ? small("repeat", t("queue.repeat"), () => because("queue/repeat", t("queue.repeat.title", { name: named(entry) }), t("queue.repeat"))) : null,
  ];
  const word = entry.verdict ? verdictText(entry.verdict) : entry.status === "done" ? t(`outcome.${entry.outcome || "unknown"}`) : t(`queue.status.${entry.status}`);
  const kind = entry.verdict || entry.outcome || entry.status;
  const note = [entry.repeats ? t("queue.repeats", { entry: entry.repeats }) : "", translate(entry.reason), entry.by].filter(Boolean).join(" · ");
  const link = (text) => (entry.run ? h("a", { class: "row-link", href: `#/runs/${encodeURIComponent(entry.run)}` }, text) : text);
  return h("tr", { class: `${OVER.has(entry.status) ? "over" : ""} ${entry.id === next ? "next" : ""}`.trim() },
    h("td", { class: "number" }, String(entry.id)), h("td", { class: "what" }, h("strong", {}, link(entry.specimen || UNKNOWN)), h("span", { class: "soft block" }, titles.get(entry.procedure) ?? breakable(entry.procedure))),
    h("td", { class: "status" }, h("span", { class: `mark ${kind.replaceAll(" ", "-")}` }, word), h("span", { class: "note block" }, note)), h("td", { class: "act" }, h("div", { class: "queue-buttons" }, buttons)));
}

// Leads to the preflight of that entry, where what fails can be overridden.
function open(entry) {
  newDraft({ procedure: entry.procedure, station: entry.station, inputs: entry.inputs, entry: entry.id, realtime: entry.realtime });
  go("#/setup");
}

// What is scanned is added at once; errors stand beside the field that they are about.
function addCard() {
  const chosen = { procedure: draft().procedure ?? "", station: ofWindow() };
  const procedure = picker("procedure", chosen, changed);
  const station = picker("station", chosen, changed);
  const scan = h("input", { type: "text", id: "queue-scan", autocomplete: "off", spellcheck: "false", "aria-describedby": "queue-scan-note" });
  const note = h("p", { class: "field-note", id: "queue-scan-note", role: "status" });
  const field = h("div", { class: "field" }, h("label", { for: "queue-scan" }, t("queue.scan")), scan, note);
  const others = h("div", {});
  const pasted = h("textarea", { id: "queue-list", rows: "5", spellcheck: "false", "aria-describedby": "queue-list-note" });
  const listNote = h("div", { class: "field-note", id: "queue-list-note", role: "status" }, t("queue.list.hint"));
  const importing = h("div", { role: "status" });
  const listField = h("div", { class: "field" }, h("label", { for: "queue-list" }, t("queue.list")), pasted, listNote, importing);
  const file = h("input", { type: "file", id: "queue-file", accept: ".csv,.txt,text/csv,text/plain", onchange: read });
  const realtime = h("input", { type: "checkbox", id: "queue-realtime", checked: draft().realtime !== false, onchange: () => keepDraft({ realtime: realtime.checked }) });
  const simulated = h("label", { class: "check", for: "queue-realtime", hidden: true }, realtime, h("span", {}, t("setup.realtime")));
  const form = h("form", { onsubmit: scanned }, field);
  let common = null;
  let requests = 0;
  let planning = null; // the latest plan that was requested
  let measured = new Set(); // names of inputs that are numbers with units

  function changed() {
    planning = plan();
    return planning;
  }

  async function plan() {
    if (chosen.station !== ofWindow()) {
      goToRig(chosen.station, "#/queue"); // each rig has a queue of its own
      return;
    }
    keepDraft({ ...chosen, entry: 0 });
    const request = ++requests;
    common = null;
    fill(others);
    if (!chosen.procedure || !chosen.station) return;
    const planned = await attempt(() => post("plan", { procedure: chosen.procedure, station: chosen.station }));
    if (!planned || request !== requests) return; // another one was chosen meanwhile
    const inputs = planned.inputs.filter((input) => input.name !== SPECIMEN);
    measured = new Set(inputs.filter((input) => input.unit).map((input) => input.name));
    show(simulated, planned.station.simulated);
    show(field, inputs.length < planned.inputs.length);
    if (inputs.length) {
      common = inputForm(chosen.procedure, inputs, draft().inputs ?? {}, (values) => keepDraft({ inputs: { ...draft().inputs, ...values } }));
      fill(others, h("h3", {}, t("queue.common")), common.element);
    }
    show(plain, inputs.length === planned.inputs.length);
  }

  const plain = button(t("queue.add"), () => add("", note, field), { kind: "primary big", hidden: true });

  async function add(list, status, where, again = "") {
    await planning; // the inputs of the lot are those of the procedure that is chosen now
    const inputs = Object.fromEntries(Object.entries(common?.values() ?? {}).filter(([, text]) => text.trim()));
    try {
      const added = await steerOrRefuse("queue/add", { ...chosen, list, inputs, operator: inputs.operator ? "" : personName(), realtime: realtime.checked, again });
      if (!added) return false;
      where.className = "field good";
      const [first, last] = [added.entries[0], added.entries.at(-1)];
      fill(status, first === last ? t("queue.added", { entry: first }) : t("queue.added_several", { first, last }));
      return true;
    } catch (error) {
      where.className = "field bad";
      const problems = error.problems.map((problem) => (problem.field === "again" ? { ...problem, field: "", hint: "" } : problem));
      if (error.asksWhy) fill(status, testedBefore(problems, list, status, where));
      else fill(status, problems.length ? problemList(problems) : refusedWords(error));
      return false;
    }
  }

  // What was tested before is added once there is a reason.
  function testedBefore(problems, list, status, where) {
    const refusal = h("div", {}, problemList(problems), button(t("queue.again"), async () => {
      const reason = await askReason(t("queue.again.title"), { confirm: t("queue.add") });
      if (!reason || !(await add(list, status, where, reason))) return;
      refusal.remove();
      if (scan.value === list) {
        scan.value = "";
        scan.setAttribute("aria-invalid", "false");
      }
      if (where === listField) pasted.value = "";
    }, { kind: "small" }));
    return refusal;
  }

  const scans = []; // waiting to be added: a scanner does not wait for the answer to its last one

  async function scanned(event) {
    event.preventDefault();
    const text = scan.value.trim();
    if (!text) return;
    scan.value = "";
    await addScan(text);
  }

  async function addScan(text) {
    const here = document.activeElement;
    if (!isField(here) && !here.closest(".dialog")) scan.focus(); // nobody types, and no question is open
    if (scans.push(text) > 1) return;
    const refusals = h("div", {});
    const latest = h("div", {});
    fill(note, refusals, latest);
    let refused = "";
    while (scans.length) {
      if (!(await add(scans[0], latest, field))) {
        refused = scans[0];
        refusals.append(...latest.childNodes); // stays, whatever is added after it
      }
      scans.shift();
    }
    if (refused) field.className = "field bad";
    scan.setAttribute("aria-invalid", String(Boolean(refused)));
    if (refused && !scan.value && document.activeElement === scan) {
      scan.value = refused;
      scan.select();
    }
  }

  async function read() {
    const [upload] = file.files;
    if (!upload) return;
    const text = upload.size > MOST_BYTES ? "" : textOf(await upload.arrayBuffer());
    const wrong = upload.size > MOST_BYTES ? t("queue.too_long", { bytes: MOST_BYTES }) : text.includes("\0") ? t("queue.no_text", { name: upload.name }) : "";
    listField.className = wrong ? "field bad" : "field";
    setText(listNote, wrong || t("queue.list.hint"));
    if (!wrong) pasted.value = text;
    file.value = "";
  }

  async function addList() {
    const list = typedList(pasted.value, measured);
    if (await working(importing, t("queue.importing"), () => add(list, listNote, listField))) pasted.value = "";
  }

  if (chosen.procedure && chosen.station) changed();
  takeScans(addScan);
  return h("section", { class: "card queue-add" }, h("h2", {}, t("queue.add_title")),
    procedure, station, form, plain, others, simulated,
    h("details", {}, h("summary", {}, t("queue.list_title")), listField,
      h("div", { class: "row" }, h("label", { class: "button", for: "queue-file" }, t("queue.file")), h("span", { class: "visually-hidden-input" }, file), button(t("queue.add_list"), addList, { kind: "primary" }))));
}

// A file as spreadsheets write it: UTF-8, UTF-16 with its mark, or the coding of Windows.
function textOf(bytes) {
  const [first, second] = new Uint8Array(bytes);
  if (first === 0xff && second === 0xfe) return new TextDecoder("utf-16le").decode(bytes);
  try {
    return new TextDecoder("utf-8", { fatal: true }).decode(bytes);
  } catch {
    return new TextDecoder("windows-1252").decode(bytes);
  }
}

function picker(kind, chosen, changed) {
  const select = h("select", { id: `queue-${kind}`, onchange: () => {
    chosen[kind] = select.value;
    if (!select.matches(":focus-visible")) select.blur(); // chosen by mouse: the letters of the next scan choose nothing
    changed();
  } }, h("option", { value: "" }, t("setup.choose")));
  attempt(() => get(`${kind}s`)).then((answer) => {
    const usable = (answer?.items ?? []).filter((item) => !item.problem);
    const first = !chosen[kind] && usable.length; // the one that was used last
    if (first) chosen[kind] = usable[0].name;
    select.append(...usable.map((item) => h("option", { value: item.name, selected: item.name === chosen[kind] }, [translate(item.title) || item.name, item.shipped ? t("choose.shipped") : ""].filter(Boolean).join(" · "))));
    if (first) changed();
  });
  return h("div", { class: "field" }, h("label", { for: `queue-${kind}` }, t(`choose.${kind}`)), select);
}
