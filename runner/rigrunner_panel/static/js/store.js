// The latest state from the server, and the listeners to its changes.

export const store = { state: null, rigs: [], connected: false, lastCurve: null, trend: newTrend() };

const listeners = new Set();

function newTrend() {
  return { first: 0, stepS: 1, channel: "", unit: "", minimum: [], maximum: [] };
}

// `listener(changed)` gets the set of sections that changed; returns how to stop listening.
export function listen(listener) {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

function emit(changed) {
  for (const listener of [...listeners]) listener(changed);
}

export function takeConnected(connected) {
  if (store.connected === connected) return;
  store.connected = connected;
  emit(new Set(["connected"]));
}

// Drops the curves of an earlier job.
function forgetCurves(before, job) {
  if (!before?.run || job?.run === before.run) return;
  store.lastCurve = null;
  store.trend = newTrend();
  emit(new Set(["curve", "trend"]));
}

// A summary of each rig; one of them may be that of this window.
export function takeRigs(rigs) {
  store.rigs = rigs;
  emit(new Set(["rigs"]));
}

export function takeState(state) {
  forgetCurves(store.state?.job, state.job);
  store.state = state;
  emit(new Set([...Object.keys(state), "connected"]));
}

export function takeChanges(seq, changes) {
  if (!store.state) return;
  if ("job" in changes) forgetCurves(store.state.job, changes.job);
  Object.assign(store.state, changes);
  store.state.seq = seq;
  emit(new Set(Object.keys(changes)));
}

const WINDOW = 1200;

export function takeFrame(frame) {
  if (frame.kind === "curve") {
    store.lastCurve = { ...frame, since: performance.now() - 1000 * frame.late_s }; // when it ended
    emit(new Set(["curve"]));
  } else if (frame.kind === "trend") {
    store.trend = joined(frame.reset || frame.channel !== store.trend.channel ? newTrend() : store.trend, frame);
    emit(new Set(["trend"]));
  }
}

// The columns of a trend with those of a frame, at most as many as the window.
export function joined(trend, frame) {
  const { minimum: low, maximum: high } = frame.curves;
  const first = trend.minimum.length ? trend.first : frame.first;
  const minimum = [...trend.minimum];
  const maximum = [...trend.maximum];
  for (let i = 0; i < low.length; i += 1) {
    const at = frame.first + i - first;
    if (at < 0) continue;
    while (minimum.length < at) {
      minimum.push(NaN);
      maximum.push(NaN);
    }
    minimum[at] = low[i];
    maximum[at] = high[i];
  }
  const over = Math.max(0, minimum.length - WINDOW);
  return { first: first + over, stepS: frame.step_s, channel: frame.channel, unit: frame.unit, minimum: minimum.slice(over), maximum: maximum.slice(over) };
}

export function hasControl() {
  const { state } = store;
  return Boolean(state?.control && state.control.client === state.you);
}
