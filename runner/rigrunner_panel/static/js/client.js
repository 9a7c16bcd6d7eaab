// Who this browser tab is, and requests to the server. The token comes in the address's fragment.

import { station } from "./address.js";

export const API = "/api/v1";
const ID = "rigrunner.client";
const TOKEN = "rigrunner.token";
const NAME = "rigrunner.name";

export class RefusedError extends Error {
  constructor(status, body) {
    super(body.message ?? `${status}`);
    this.status = status;
    this.code = body.code ?? "bug";
    this.hint = body.hint ?? "";
    this.problems = body.problems ?? [];
  }

  // Whether a reason is all that is missing: the specimens were tested before.
  get asksWhy() {
    return this.problems.length > 0 && this.problems.every((problem) => problem.field === "again");
  }
}

export function clientId() {
  let id = sessionStorage.getItem(ID);
  if (!id) {
    id = Array.from(crypto.getRandomValues(new Uint8Array(12)), (n) => n.toString(16).padStart(2, "0")).join("");
    sessionStorage.setItem(ID, id);
  }
  return id;
}

export function token() {
  return sessionStorage.getItem(TOKEN) ?? "";
}

export function takeToken() {
  const match = /(?:^#|&)token=([^&]+)/.exec(location.hash);
  if (!match) return;
  sessionStorage.setItem(TOKEN, decodeURIComponent(match[1]));
  history.replaceState(null, "", location.pathname + location.search);
}

export function personName() {
  return localStorage.getItem(NAME) ?? "";
}

export function keepPersonName(name) {
  localStorage.setItem(NAME, name);
}

function headers(more = {}) {
  return token() ? { Authorization: `Bearer ${token()}`, ...more } : more;
}

async function answerOf(request) {
  let response;
  try {
    response = await request;
  } catch {
    throw new RefusedError(0, { code: "no_connection", message: "" });
  }
  const text = await response.text();
  let body = {};
  try {
    body = text ? JSON.parse(text) : {};
  } catch {
    body = { message: text.slice(0, 200) };
  }
  if (!response.ok) throw new RefusedError(response.status, body);
  return body;
}

export function get(path, query = {}) {
  const entries = Object.entries({ rig: station(), ...query }).filter(([, value]) => value !== "" && value !== null && value !== undefined);
  const search = new URLSearchParams(entries).toString();
  return answerOf(fetch(`${API}/${path}${search ? `?${search}` : ""}`, { headers: headers() }));
}

// `rig` is the station of the rig; "" for a request that concerns none, or all.
export function post(path, body = {}, rig = station()) {
  const query = rig ? `?rig=${encodeURIComponent(rig)}` : "";
  return answerOf(
    fetch(`${API}/${path}${query}`, {
      method: "POST",
      headers: headers({ "Content-Type": "application/json", "X-Rigrunner-Client": clientId() }),
      body: JSON.stringify(body),
    }),
  );
}
