// What was chosen for the next run: kept in this tab until it is started.

const KEPT = "rigrunner.draft";

export function draft() {
  try {
    return JSON.parse(sessionStorage.getItem(KEPT)) ?? {};
  } catch {
    return {};
  }
}

export function keepDraft(changes) {
  const kept = { ...draft(), ...changes };
  sessionStorage.setItem(KEPT, JSON.stringify(kept));
  return kept;
}

export function newDraft(values) {
  sessionStorage.setItem(KEPT, JSON.stringify(values));
}
