// Requests that need control: it is taken first, and errors are shown.

import { station } from "./address.js";
import { keepPersonName, personName, post } from "./client.js";
import { draft } from "./draft.js";
import { askName, confirmTakeOver } from "./parts/dialogs.js";
import { forgetErrors, notify, notifyError } from "./parts/notices.js";
import { hasControl, store } from "./store.js";
import { t } from "./texts.js";

// The name of the person at this screen: entered before, typed on this page, or else asked for.
async function nameOf(typed, options) {
  const name = personName() || typed || draft().inputs?.operator?.trim() || (await askName(options));
  if (name) keepPersonName(name);
  return name ?? "";
}

// Takes control; returns whether this client has it. `typed` is the name of a person in a field of the page.
export async function takeControl(typed = "") {
  if (hasControl()) return true;
  if (!station()) {
    notify(t("control.no_rig"));
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

// The name of the person at this screen; '' if it was not entered.
export async function person(title, confirm) {
  return nameOf("", { title, confirm });
}

export async function releaseControl() {
  await attempt(() => post("control/release"));
}

const underWay = new Set();

// Sends a request that needs control; returns null without control, and throws RefusedError if it is refused.
// The same one again, before the answer is there, is a double click: it is not sent.
export async function steerOrRefuse(path, body = {}) {
  const key = JSON.stringify([path, body]);
  if (underWay.has(key)) return null;
  underWay.add(key);
  try {
    return (await takeControl()) ? await post(path, body) : null;
  } finally {
    underWay.delete(key);
  }
}

// Sends a request that needs control; returns its answer, or null if it was refused, and shows the error.
export async function steer(path, body = {}) {
  return attempt(() => steerOrRefuse(path, body));
}

export async function attempt(work) {
  try {
    const answer = await work();
    if (answer !== null) forgetErrors();
    return answer;
  } catch (error) {
    notifyError(error);
    return null;
  }
}

// Stops a rig; all of them where there is none of this window.
export async function stopNow(rig = station()) {
  await attempt(() => post("stop", { reason: "stop button" }, rig));
}
