// What procedures and stations are called, by the names of their files.

import { get } from "./client.js";
import { tried } from "./steer.js";
import { said } from "./texts.js";

export async function titlesOf(kind) {
  const found = await tried(() => get(kind));
  return new Map((found?.items ?? []).map((item) => [item.name, said(item.title) || item.name]));
}
