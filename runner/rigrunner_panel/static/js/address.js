// The address: its fragment names the page, its query the rig whose page it is.

let only = ""; // the rig that is meant where the address names none

export function go(hash) {
  location.hash = hash;
}

// The station of the rig that this window is at; "" for the overview of several.
export function station() {
  return new URLSearchParams(location.search).get("rig") ?? only;
}

export function settleOn(name) {
  only = name;
}

export function rigAddress(name, hash = "#/") {
  return `/?rig=${encodeURIComponent(name)}${hash}`;
}

// Goes to a page of a rig; to that of another one with a new start, so that nothing of this one stays.
export function goToRig(name, hash) {
  if (name === station()) go(hash);
  else location.assign(rigAddress(name, hash));
}
