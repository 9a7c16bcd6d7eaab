// From the address's fragment to a page. A page is built again at each visit.

import { go, station } from "./address.js";
import { fill } from "./dom.js";
import { dismissDialog } from "./parts/dialogs.js";
import { choosePage } from "./pages/choose.js";
import { comparePage } from "./pages/compare.js";
import { historyPage } from "./pages/history.js";
import { manualPage } from "./pages/manual.js";
import { overlayPage } from "./pages/overlay.js";
import { procedurePage } from "./pages/procedure.js";
import { proceduresPage } from "./pages/procedures.js";
import { overviewPage } from "./pages/overview.js";
import { queuePage } from "./pages/queue.js";
import { resultPage } from "./pages/result.js";
import { runPage } from "./pages/run.js";
import { setupPage } from "./pages/setup.js";
import { trendsPage } from "./pages/trends.js";
import { listen, store } from "./store.js";

// A page is a function of the words of the address that returns {title, element, leave}.
const PAGES = {
  "": () => (station() ? choosePage() : overviewPage()),
  rigs: overviewPage,
  choose: choosePage,
  setup: setupPage,
  run: runPage,
  manual: manualPage,
  queue: queuePage,
  procedures: (name) => (name ? procedurePage(name) : proceduresPage()),
  history: historyPage,
  runs: resultPage,
  compare: comparePage,
  overlay: overlayPage,
  trends: trendsPage,
};

const OF_A_RIG = new Set(["setup", "run", "manual", "queue"]);
const RUNNING = new Set(["starting", "running", "asking", "pausing", "paused", "ending", "analysing"]);

export function startRouter(host) {
  let present = null;

  function open() {
    const [name = "", ...words] = location.hash.replace(/^#\/?/, "").split("/").map(decodeURIComponent);
    dismissDialog();
    present?.leave?.();
    present = (PAGES[OF_A_RIG.has(name) && !station() ? "" : name] ?? PAGES[""])(...words);
    document.title = `${present.title} - Rigrunner`;
    fill(host, present.element);
    host.focus({ preventScroll: true });
    window.scrollTo(0, 0);
  }

  let before = null;
  listen((changed) => {
    if (!changed.has("phase") || !store.state) return;
    const { phase, job, finished } = store.state;
    const was = before;
    before = phase;
    if (was === phase) return;
    const here = location.hash || "#/";
    const steering = here === "#/" || here.startsWith("#/setup") || here.startsWith("#/run") || here.startsWith("#/queue");
    if (RUNNING.has(phase) && job?.kind === "run" && steering && !here.startsWith("#/runs/")) {
      if (here !== "#/run") go("#/run");
    } else if (phase === "finished" && was !== null && here === "#/run" && finished?.run) {
      go(`#/runs/${encodeURIComponent(finished.run)}`);
    }
  });
  window.addEventListener("hashchange", open);
  open();
}
