// The WebSocket: the whole state first, then what changes; curves come as binary frames.

import { station } from "./address.js";
import { API, clientId, token } from "./client.js";

const FIRST_WAIT_MS = 250;
const LONGEST_WAIT_MS = 4000;

export function decodeFrame(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const curves = {};
  let at = 4 + length;
  for (const [name, count] of header.arrays) {
    curves[name] = new Float32Array(buffer, at, count);
    at += 4 * count;
  }
  return { ...header, curves };
}

// `on` has connected(bool), rigs(rigs), state(state), changes(seq, changes) and frame(frame).
export function openLink(on) {
  let wait = FIRST_WAIT_MS;

  function open() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const address = `${scheme}://${location.host}${API}/events?client=${clientId()}&rig=${encodeURIComponent(station())}`;
    const protocols = token() ? ["rigrunner.v1", `token.${token()}`] : ["rigrunner.v1"];
    const socket = new WebSocket(address, protocols);
    socket.binaryType = "arraybuffer";
    socket.onmessage = ({ data }) => {
      if (typeof data !== "string") {
        on.frame(decodeFrame(data));
        return;
      }
      const message = JSON.parse(data);
      if (message.type === "state") {
        wait = FIRST_WAIT_MS;
        on.state(message.state);
        on.connected(true);
      } else if (message.type === "rigs") {
        wait = FIRST_WAIT_MS;
        on.rigs(message.rigs);
        if (!station()) on.connected(true);
      } else if (message.type === "delta") {
        on.changes(message.seq, message.changes);
      }
    };
    socket.onclose = () => {
      on.connected(false);
      setTimeout(open, wait);
      wait = Math.min(2 * wait, LONGEST_WAIT_MS);
    };
  }

  open();
}
