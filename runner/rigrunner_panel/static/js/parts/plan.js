// The preview of a run: duration, disk, torque to be expected, and all steps.

import { h } from "../dom.js";
import { bytes, duration, fixed, plain } from "../format.js";
import { said, t } from "../texts.js";
import { stepWords } from "./steps.js";

const NEARLY_FULL = 0.8;

// What a run would do, as `rigrunner plan` has it.
export function planFacts(plan) {
  const torques = plan.torques.map((torque) => {
    const sign = torque.share > 1 ? "✗" : torque.share > NEARLY_FULL ? "!" : "";
    return h("tr", {},
      h("td", {}, `${plain(torque.frequency_hz)} Hz`),
      h("td", {}, `${fixed(torque.peak_nm, 2)} N·m`),
      h("td", {}, h("meter", { min: "0", max: "1.01", low: String(NEARLY_FULL), high: "1", optimum: "0", value: String(torque.share), "aria-label": t("setup.share") }), ` ${fixed(100 * torque.share, 0)} % `, h("strong", {}, sign)));
  });
  const partners = plan.partners.flatMap((each) => [h("dt", {}, said(each.words)), h("dd", { class: each.problem ? "bad-text" : "" }, each.run || said(each.problem), each.hint ? h("span", { class: "hint block" }, said(each.hint)) : null)]);
  return [
    ...plan.warnings.map((warning) => h("p", { class: "banner warn" }, said(warning))),
    h("dl", { class: "facts" },
      h("dt", {}, t("setup.station")), h("dd", {}, said(plan.station.title)),
      h("dt", {}, t("setup.revision")), h("dd", {}, `${plan.procedure.id} ${plan.procedure.revision}`),
      h("dt", {}, t("setup.duration")), h("dd", {}, duration(plan.estimated_s)),
      h("dt", {}, t("setup.steps")), h("dd", {}, String(plan.steps.length)),
      h("dt", {}, t("setup.disk")), h("dd", {}, t("setup.disk_of", { needs: bytes(plan.disk_bytes), free: bytes(plan.disk_free_bytes) })),
      partners),
    torques.length ? h("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": t("setup.torques") }, h("table", {}, h("caption", {}, t("setup.torques")), h("thead", {}, h("tr", {}, h("th", {}, t("setup.frequency")), h("th", {}, t("setup.peak")), h("th", {}, t("setup.share")))), h("tbody", {}, torques))) : null,
    h("details", {}, h("summary", {}, t("setup.all_steps")), h("ol", { class: "step-texts" }, plan.steps.map((step) => h("li", {}, stepWords(step))))),
  ];
}
