// Before the run: what it will do, the answers that it needs, and the preflight.

import { go } from "../address.js";
import { personName, post } from "../client.js";
import { button, fill, h, setText, show } from "../dom.js";
import { draft, keepDraft } from "../draft.js";
import { isBusy } from "../parts/bar.js";
import { askReason } from "../parts/dialogs.js";
import { inputForm } from "../parts/inputs.js";
import { problemList } from "../parts/notices.js";
import { planFacts } from "../parts/plan.js";
import { preflightCard } from "../parts/preflight.js";
import { working } from "../parts/working.js";
import { steer, steerOrRefuse, attempt } from "../steer.js";
import { listen, store } from "../store.js";
import { translate, t } from "../texts.js";

export function setupPage() {
  const { procedure, station } = draft();
  const heading = h("h1", {}, t("setup.title"));
  const body = h("div", { class: "three" });
  const element = h("div", { class: "page setup" },
    h("div", { class: "head" }, heading, h("a", { class: "button", href: "#/" }, t("setup.back"))), body);
  const forgets = [];
  if (!procedure || !station) {
    fill(body, h("p", { class: "banner info" }, t("setup.nothing"), h("a", { class: "button", href: "#/" }, t("choose.title"))));
    return { title: t("setup.title"), element };
  }
  load();

  async function load() {
    let plan;
    try {
      plan = await working(body, t("loading"), () => post("plan", { procedure, station }));
    } catch (error) {
      fill(body, h("section", { class: "card bad-card" }, h("h2", {}, t("setup.invalid")), h("p", {}, translate(error.message)), error.hint ? h("p", { class: "hint" }, translate(error.hint)) : null, problemList(error.problems ?? [])));
      return;
    }
    setText(heading, translate(plan.procedure.title));
    const inputs = inputForm(procedure, plan.inputs, draft().inputs ?? {}, (values) => keepDraft({ inputs: values }));
    const realtime = h("input", { type: "checkbox", id: "realtime", checked: draft().realtime !== false, onchange: () => keepDraft({ realtime: realtime.checked }) });
    const card = preflightCard({ procedure, station });
    const start = button(t("setup.start"), () => begin(inputs, card, realtime, plan), { kind: "primary big" });
    const later = button(t("queue.add"), () => enqueue(inputs, realtime, plan), { kind: "big" });
    const hint = h("p", { class: "soft", role: "status" });

    function update() {
      const missing = inputs.missing();
      const ready = !missing.length;
      const may = card.may();
      const inUse = isBusy(store.state) && store.state.phase !== "checking";
      start.disabled = !(ready && may) || inUse;
      later.disabled = !ready;
      show(later, !draft().entry);
      setText(hint, inUse ? t("setup.in_use") : !ready ? t("setup.needs_inputs", { names: missing.join(", ") }) : !card.done() ? t("setup.needs_preflight") : !may ? t("setup.needs_fixing") : t("setup.ready"));
    }

    inputs.onchange = update;
    card.onchange = update;
    forgets.push(listen((changed) => {
      if (changed.has("preflight") || changed.has("phase")) {
        card.update();
        update();
      }
    }));
    fill(body,
      h("section", { class: "card" }, h("h2", {}, t("setup.plan")), planFacts(plan)),
      h("section", { class: "card" }, h("h2", {}, t("setup.inputs")), inputs.element,
        plan.station.simulated ? h("label", { class: "check", for: "realtime" }, realtime, h("span", {}, t("setup.realtime"))) : null),
      h("div", { class: "stack" }, card.element, h("section", { class: "card start-card" }, hint, h("div", { class: "start-buttons" }, start, later))));
    card.update();
    update();
    if (Object.values(draft().inputs ?? {}).some(Boolean)) inputs.toEmpty(); // of the next specimen, which may be scanned at once
  }

  return { title: t("setup.title"), element, leave: () => forgets.forEach((forget) => forget()) };
}

// Returns the run that was set up, with the partner runs that the plan was shown with.
function requested(inputs, realtime, plan) {
  const values = inputs.values();
  const { procedure, station } = draft();
  const partners = Object.fromEntries(plan.partners.filter((partner) => partner.run).map((partner) => [partner.name, partner.run]));
  return { procedure, station, inputs: values, operator: values.operator ? "" : personName(), partners, realtime: realtime.checked };
}

async function begin(inputs, card, realtime, plan) {
  const body = requested(inputs, realtime, plan);
  const override = card.override();
  if (override) body.override = override;
  if (draft().entry) body.entry = draft().entry;
  const started = await steer("run/start", body);
  if (!started) return;
  keepDraft({ entry: 0 });
  go(started.entry ? "#/queue" : "#/run");
}

async function enqueue(inputs, realtime, plan) {
  const body = requested(inputs, realtime, plan);
  const added = await attempt(async () => {
    try {
      return await steerOrRefuse("queue/add", body);
    } catch (error) {
      if (!error.asksWhy) throw error;
      const again = await askReason(t("queue.again.title"), { confirm: t("queue.add") });
      return again ? steerOrRefuse("queue/add", { ...body, again }) : null;
    }
  });
  if (added) go("#/queue");
}
