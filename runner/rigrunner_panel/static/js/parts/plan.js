// The preview of a run: duration, disk, readings to be expected, and all steps.

import { breakable, h } from "../dom.js";
import { bytes, duration, fixed, plain } from "../format.js";
import { translate, t } from "../texts.js";
import { stepWords } from "./steps.js";

const NEARLY_FULL = 0.8;

// What a run would do, as `rigrunner plan` has it.
export function planFacts(plan) {
  const channels = [...new Set(plan.readings.map((reading) => reading.channel))];
  const isSingle = channels.length === 1; // it is named once: the column would take the room of the share
  const caption = isSingle ? t("setup.readings_of", { channel: channels[0] }) : t("setup.readings");
  const head = ["setup.recording", isSingle ? "" : "setup.channel", "setup.peak", "setup.share"].filter(Boolean);
  const readings = plan.readings.map((reading) => {
    const sign = reading.share > 1 ? "✗" : reading.share > NEARLY_FULL ? "!" : "";
    return h("tr", {},
      h("td", {}, reading.recording),
      isSingle ? null : h("td", {}, reading.channel),
      h("td", {}, `${plain(Number(reading.peak.toPrecision(3)))} ${reading.unit}`),
      h("td", {}, h("meter", { min: "0", max: "1.01", low: String(NEARLY_FULL), high: "1", optimum: "0", value: String(reading.share), "aria-label": t("setup.share") }), ` ${fixed(100 * reading.share, 0)} % `, h("strong", {}, sign)));
  });
  const partners = plan.partners.flatMap((partner) => [h("dt", {}, translate(partner.words)), h("dd", { class: partner.problem ? "bad-text" : "" }, partner.run ? breakable(partner.run) : translate(partner.problem), partner.hint ? h("span", { class: "hint block" }, translate(partner.hint)) : null)]);
  return [
    ...plan.warnings.map((warning) => h("p", { class: "banner warn" }, translate(warning))),
    h("dl", { class: "facts" },
      h("dt", {}, t("setup.station")), h("dd", {}, translate(plan.station.title)),
      h("dt", {}, t("setup.revision")), h("dd", {}, `${plan.procedure.id} ${plan.procedure.revision}`),
      h("dt", {}, t("setup.duration")), h("dd", {}, duration(plan.estimated_s)),
      h("dt", {}, t("setup.steps")), h("dd", {}, String(plan.steps.length)),
      h("dt", {}, t("setup.disk")), h("dd", {}, t("setup.disk_of", { needs: bytes(plan.disk_bytes), free: bytes(plan.disk_free_bytes) })),
      partners),
    readings.length ? h("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption }, h("table", {}, h("caption", {}, caption), h("thead", {}, h("tr", {}, head.map((key) => h("th", { scope: "col" }, t(key))))), h("tbody", {}, readings))) : null,
    h("details", {}, h("summary", {}, t("setup.all_steps")), h("ol", { class: "step-texts" }, plan.steps.map((step) => h("li", {}, stepWords(step))))),
  ];
}
