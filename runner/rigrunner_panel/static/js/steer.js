// Requests that steer: control is asked for first, and what is refused is shown.

import { station } from "./address.js";
import { keepPersonName, personName, post } from "./client.js";
import { draft } from "./draft.js";
import { askName, confirmTakeOver } from "./parts/dialogs.js";
import { forgetErrors, tell, tellError } from "./parts/notices.js";
import { hasControl, store } from "./store.js";
import { t } from "./texts.js";

// The name of the person at this screen: as given before or typed on this page, else asked for.
async function nameOf(typed, options) {
  const name = personName() || typed || draft().inputs?.operator?.trim() || (await askName(options));
  if (name) keepPersonName(name);
  return name ?? "";
}

// Takes control; returns whether it was had. `typed` is the name of a person in a field of the page.
export async function takeControl(typed = "") {
  if (hasControl()) return true;
  if (!station()) {
    tell(t("control.no_rig"));
    return false;
  }
  const name = await nameOf(typed);
  if (!name) return false;
  const holder = store.state?.control;
  const isBack = holder && !holder.connected && holder.name === name; // in another tab, which is closed
  if (holder && !isBack && !(await confirmTakeOver(holder.name))) return false;
  await post("control", { name, take_over: Boolean(holder) });
  return true;
}

// The name of the person at this screen; '' where it was asked for and not given.
export async function person(title, confirm) {
  return nameOf("", { title, confirm });
}

export async function releaseControl() {
  await tried(() => post("control/release"));
}

const underWay = new Set();

// Does a request that needs control; null where that was not had, and a RefusedError where it was refused.
// The same one again, before the answer is there, is a double click: it is not sent.
export async function steerOrRefuse(path, body = {}) {
  const wanted = JSON.stringify([path, body]);
  if (underWay.has(wanted)) return null;
  underWay.add(wanted);
  try {
    return (await takeControl()) ? await post(path, body) : null;
  } finally {
    underWay.delete(wanted);
  }
}

// Does a request that needs control; returns its answer, or null where it was refused.
export async function steer(path, body = {}) {
  return tried(() => steerOrRefuse(path, body));
}

export async function tried(work) {
  try {
    const answer = await work();
    if (answer !== null) forgetErrors();
    return answer;
  } catch (error) {
    tellError(error);
    return null;
  }
}

// Stops a rig; all of them where there is none of this window.
export async function stopNow(rig = station()) {
  await tried(() => post("stop", { reason: "stop button" }, rig));
}
