// Where it all begins: texts, top bar, link to the server, and the page that the address names.

import { settleOn, station } from "./address.js";
import { get, takeToken } from "./client.js";
import { fill, h } from "./dom.js";
import { openLink } from "./link.js";
import { topBar } from "./parts/bar.js";
import { dialogHost } from "./parts/dialogs.js";
import { lostBanner } from "./parts/lost.js";
import { noticesElement } from "./parts/notices.js";
import { keys } from "./parts/keys.js";
import { keepScansOut } from "./parts/scanner.js";
import { startRouter } from "./router.js";
import { takeChanges, takeConnected, takeFrame, takeRigs, takeState } from "./store.js";
import { loadTexts, t } from "./texts.js";
import { applyTheme, watchTheme } from "./theme.js";

takeToken();
applyTheme();
watchTheme();
await loadTexts();
await findRig();

const page = h("main", { id: "page", tabindex: "-1" });
const skip = h("a", { class: "skip", href: "#page", onclick: (event) => {
  event.preventDefault();
  page.focus();
} }, t("skip"));
fill(document.body, skip, topBar(), lostBanner(), noticesElement(), page, dialogHost());
document.addEventListener("keydown", keys);
keepScansOut(document);
startRouter(page);
openLink({ connected: takeConnected, rigs: takeRigs, state: takeState, changes: takeChanges, frame: takeFrame });

// Where there is one rig, nobody has to choose it.
async function findRig() {
  if (station()) return;
  try {
    const { rigs } = await get("rigs");
    if (rigs.length === 1) settleOn(rigs[0].station);
  } catch {
    // the banner says that there is no connection, or no token
  }
}
