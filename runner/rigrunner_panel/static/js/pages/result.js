// A finished run: verdict, numbers, checks, report and certificate, and the next specimen.

import { go, goToRig, station } from "../address.js";
import { get } from "../client.js";
import { breakable, button, fill, h } from "../dom.js";
import { draft, newDraft } from "../draft.js";
import { bytes, localTime, shownNumber, shownQuantity, withUncertainty } from "../format.js";
import { certificateForm } from "../parts/certificate.js";
import { certificateList } from "../parts/certificates.js";
import { askForm, askReason } from "../parts/dialogs.js";
import { endedBanners } from "../parts/ended.js";
import { resultTables, storedResults } from "../parts/results.js";
import { SIGNS, verdictText } from "../parts/verdict.js";
import { working } from "../parts/working.js";
import { steer, attempt } from "../steer.js";
import { store } from "../store.js";
import { translate, t } from "../texts.js";

const NOT_CHECKED = "not checked: "; // how the text of a check begins that could not be made

const CONCLUDED = ["completed", "stopped at a limit"]; // how a run ends that has a verdict
const MOST_LIMITS = 50;

export function resultPage(run) {
  const body = h("div", { class: "result-body" });
  const element = h("div", { class: "page result" }, body);

  async function load() {
    const detail = await working(body, t("loading"), () => attempt(() => get(`runs/${encodeURIComponent(run)}`)));
    if (detail) show(detail);
    else fill(body, h("p", { class: "banner warn" }, t("result.gone")));
  }

  async function again() {
    const next = await attempt(() => get(`runs/${encodeURIComponent(run)}/again`));
    if (!next) return;
    if (!next.procedure || !next.station) {
      go("#/");
      return;
    }
    newDraft({ procedure: next.procedure, station: next.station, inputs: next.inputs, realtime: draft(next.station).realtime });
    goToRig(next.station, "#/setup");
  }

  // Asks, at the rig of the run, and sends the request; errors are shown.
  async function finish(ask, path) {
    const next = await attempt(() => get(`runs/${encodeURIComponent(run)}/again`));
    if (!next) return null;
    if (next.station && next.station !== station()) {
      goToRig(next.station, `#/runs/${encodeURIComponent(run)}`);
      return null;
    }
    const answer = await ask();
    return answer && steer(`runs/${encodeURIComponent(run)}/${path}`, answer.body);
  }

  async function resume() {
    const ask = () => askForm(t("unfinished.resume.title"), [h("p", {}, t("unfinished.resume.text"))], { confirm: t("unfinished.resume.yes"), read: () => ({ body: {} }) });
    if (await finish(ask, "resume")) go("#/run");
  }

  async function close() {
    const ask = async () => {
      const reason = await askReason(t("unfinished.close.title"), { confirm: t("unfinished.close"), required: false });
      return reason === null ? null : { body: { reason } };
    };
    if (await finish(ask, "recover")) load();
  }

  function unfinished() {
    return h("div", { class: "banner info wide" }, h("span", {}, t("unfinished.text")),
      h("div", { class: "row" }, button(t("unfinished.resume"), resume, { kind: "primary" }), button(t("unfinished.close"), close)));
  }

  function show(detail) {
    const documents = certificateList(run);
    const report = detail.files.find((file) => file.name === "report.html");
    const frame = report ? h("iframe", { class: "report", src: report.url, title: t("result.report") }) : h("p", { class: "soft" }, t("result.no_report"));
    fill(body,
      head(detail, again, detail.item.interrupted ? unfinished() : null),
      h("div", { class: "result-columns" },
        h("div", { class: "stack" }, facts(detail), results(detail), limits(detail), checks(detail), files(detail), documents.element, CONCLUDED.includes(detail.item.outcome) ? certificateForm(run, detail.inputs, documents.load) : null),
        h("section", { class: "card report-card" },
          h("div", { class: "head" }, h("h2", {}, t("result.report")), report ? h("a", { class: "button", href: report.url, target: "_blank", rel: "noopener" }, t("result.open_report")) : null), frame)));
  }

  load();
  return { title: t("result.title"), element };
}

function head({ item, reason }, again, unfinished) {
  const finished = store.state?.finished;
  const mine = finished?.run === item.run ? finished : null;
  const verdict = item.verdict;
  const kind = verdict ? verdict.replaceAll(" ", "-") : CONCLUDED.includes(item.outcome) ? "none" : item.outcome || "unknown";
  const word = verdict ? `${SIGNS[verdict] ?? "~"} ${verdictText(verdict)}` : t(`outcome.${item.outcome || "unknown"}`);
  const cause = mine?.error || reason;
  return h("div", { class: "result-head" },
    h("div", {}, h("h1", {}, translate(item.title) || item.run), h("p", { class: "soft" }, [item.specimen, item.station, localTime(item.started_utc), item.operator].filter(Boolean).join(" · "))),
    h("div", { class: `verdict ${kind}` }, h("strong", { class: "verdict-word" }, word),
      h("span", { class: "verdict-value" }, item.headline ? withUncertainty(item.headline.value, item.headline.U, item.headline.unit) : shownNumber(item.result ?? ""))),
    button(t("result.again"), again, { kind: "primary big" }),
    item.outcome !== "completed" ? endedBanners(cause, { isNow: Boolean(mine), hint: mine?.hint }) : null,
    unfinished);
}

function facts(detail) {
  const rows = Object.entries(detail.inputs).flatMap(([name, value]) => [h("dt", {}, translate(name)), h("dd", {}, shownQuantity(value))]);
  return h("section", { class: "card" }, h("h2", {}, t("result.facts")),
    h("dl", { class: "facts" }, rows,
      h("dt", {}, t("result.run")), h("dd", {}, breakable(detail.item.run)),
      h("dt", {}, t("result.sealed")), h("dd", {}, detail.sealed ? t("yes") : t("no")),
      detail.approval.state ? [h("dt", {}, t("result.approval")), h("dd", {}, t(`result.state.${detail.approval.state}`))] : null));
}

// Measured values with limits: those out of limits first, all on a click.
function limits(detail) {
  const { values, judged, missed } = detail.result?.limits ?? {};
  if (!values) return null;
  const item = (value) => {
    const [kind, sign] = value.verdict === "fail" ? ["fail", SIGNS.fail] : ["ok", SIGNS.pass];
    return h("li", { class: `light ${kind}` },
      h("span", { class: "sign", role: "img", "aria-label": verdictText(value.verdict) }, sign),
      h("div", { class: "light-text" }, h("strong", {}, `${value.of}: ${shownNumber(value.shown)}`), h("span", {}, t("limits.allowed", { allowed: shownNumber(translate(value.allowed)) })), h("span", { class: "soft" }, `${value.table} ${value.row}`)));
  };
  const list = (items) => h("ul", { class: "lights" }, items.slice(0, MOST_LIMITS).map(item));
  const failed = values.filter((value) => value.verdict === "fail");
  return h("section", { class: "card" }, h("h2", {}, t("limits.title")),
    h("p", { class: missed ? "" : "good-text" }, t(missed ? "limits.missed" : "limits.none_missed", { missed, judged })),
    failed.length ? list(failed) : null,
    h("details", {}, h("summary", {}, t("limits.all", { judged })), list(values), judged > MOST_LIMITS ? h("p", { class: "soft" }, t("limits.more")) : null));
}

function results(detail) {
  const rows = storedResults(detail.result);
  return rows.length ? h("section", { class: "card" }, h("h2", {}, t("results.title")), h("div", { class: "live-results" }, resultTables(rows))) : null;
}

// The checks of the run and of each method, as in the report.
function allChecks(result) {
  const methods = Object.entries(result?.compensations ?? {});
  return [...(result?.checks ?? []), ...methods.flatMap(([method, { checks: list }]) => list.map((check) => ({ ...check, name: check.name, method })))];
}

function nameOf({ name, method }) {
  return method ? `${translate(name)} (${method})` : translate(name);
}

function checks(detail) {
  const all = allChecks(detail.result);
  if (!all.length) return null;
  const failed = all.filter((check) => !check.ok);
  const skipped = all.filter((check) => check.ok && check.text.startsWith(NOT_CHECKED));
  const performed = all.length - skipped.length;
  const item = (check) => {
    const [kind, sign] = !check.ok ? ["warn", "!"] : check.consequence === "note" ? ["note", "\u00b7"] : skipped.includes(check) ? ["skipped", "\u2013"] : ["ok", "✓"];
    return h("li", { class: `light ${kind}` },
      h("span", { class: "sign", role: "img", "aria-label": t(`check.${kind}`) }, sign),
      h("div", { class: "light-text" }, h("strong", {}, nameOf(check)), h("span", {}, shownNumber(translate(check.text ?? ""))), check.effect ? h("span", { class: "soft" }, t("check.effect", { effect: shownNumber(translate(check.effect)) })) : null, check.advice ? h("span", { class: "fix" }, translate(check.advice)) : null));
  };
  return h("section", { class: "card" }, h("h2", {}, t("result.checks")),
    failed.length ? h("ul", { class: "lights" }, failed.map(item)) : performed ? h("p", { class: "good-text" }, t("result.all_good", { count: performed })) : null,
    skipped.length ? h("p", { class: "soft" }, t("result.not_made", { names: skipped.map(nameOf).join(", ") })) : null,
    h("details", {}, h("summary", {}, t("result.all_checks", { count: all.length })), h("ul", { class: "lights" }, all.map(item))));
}

function files(detail) {
  return h("section", { class: "card" }, h("h2", {}, t("result.files")),
    h("ul", { class: "files" }, detail.files.map((file) => h("li", {}, h("a", { href: file.url, target: "_blank", rel: "noopener" }, file.name), h("span", { class: "soft" }, bytes(file.size))))));
}
