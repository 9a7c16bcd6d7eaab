// The keys that work on every page.

import { askReason } from "./dialogs.js";
import { steer, stopNow } from "../steer.js";
import { store } from "../store.js";
import { t } from "../texts.js";

export async function pauseOrResume() {
  const phase = store.state?.phase; // none on the overview
  if (phase === "paused") await steer("run/resume");
  else if (phase === "running" || phase === "asking") await steer("run/pause");
}

export async function abort() {
  const reason = await askReason(t("run.abort.title"), { confirm: t("run.abort"), kind: "danger" });
  if (reason) await steer("run/abort", { reason });
}

export function keys(event) {
  if (event.repeat) return;
  if (event.key === "F9") {
    event.preventDefault();
    stopNow();
  } else if (event.key === "F8") {
    event.preventDefault();
    pauseOrResume();
  }
}
