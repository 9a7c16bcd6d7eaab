// The choices for the next run of a rig: stored in this tab until it is started.

import { station } from "./address.js";

const STORAGE_KEY = "rigrunner.draft";

function key(rig) {
  return `${STORAGE_KEY}.${rig}`;
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
