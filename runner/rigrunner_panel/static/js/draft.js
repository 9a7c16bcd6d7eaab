// What was chosen for the next run of a rig: kept in this tab until it is started.

import { station } from "./address.js";

const KEPT = "rigrunner.draft";

function key(rig) {
  return `${KEPT}.${rig}`;
}

export function draft(rig = station()) {
  try {
    return { ...JSON.parse(sessionStorage.getItem(key(rig))), station: rig };
  } catch {
    return { station: rig };
  }
}

export function keepDraft(changes) {
  newDraft({ ...draft(changes.station), ...changes });
}

// A draft is that of the station that it names, which is part of its key alone.
export function newDraft({ station: rig = station(), ...values }) {
  sessionStorage.setItem(key(rig), JSON.stringify(values));
}
