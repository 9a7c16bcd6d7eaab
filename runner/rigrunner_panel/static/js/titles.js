// Titles of procedures and stations, by the names of their files.

import { get } from "./client.js";
import { attempt } from "./steer.js";
import { translate } from "./texts.js";

export async function titlesOf(kind) {
  const answer = await attempt(() => get(kind));
  return new Map((answer?.items ?? []).map((item) => [item.name, translate(item.title) || item.name]));
}
