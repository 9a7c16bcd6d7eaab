// Where in a YAML text one is: by which keys and list items one comes there. It reads a text that is
// still being written, of which a parser would only say that it is none.

const KEY = /^("(?:[^"\\]|\\.)*"|'[^']*'|[^\s#:{}[\],&*!|>%@`"'][^:#{}[\],]*?)\s*:(?=\s|$)/;
const ITEM = /^-(\s+|$)/;

// The place of the end of a text: {path, kind, word}. `kind` is "value" behind a key or in a list
// written with brackets, else "key"; of that the path is the mapping's. `word` is what is begun.
// null within a text over several lines or a comment. `onKey(path, key)` is called for each complete key.
export function placeAt(text, onKey = () => {}) {
  const lines = text.split("\n");
  const open = []; // {column, key} or {column, index}
  let flow = null;
  let literal = -1; // the column of the key whose text goes over several lines
  const path = () => open.map((level) => level.key ?? level.index);

  for (let i = 0; i < lines.length; i += 1) {
    const last = i === lines.length - 1;
    const line = lines[i];
    const blank = !line.trim();
    const indent = blank ? line.length : line.search(/\S/);
    if (literal >= 0) {
      if (blank ? !last || indent > literal : indent > literal) {
        if (last) return null;
        continue;
      }
      literal = -1;
    }
    if (flow) {
      flow = read(flow, line, onKey);
      if (last) return flow?.place() ?? null;
      continue;
    }
    if (line.trimStart().startsWith("#")) {
      if (last) return null;
      continue;
    }
    if (blank && !last) continue;

    let column = indent;
    let remainder = line.slice(indent);
    for (let match; (match = ITEM.exec(remainder)); ) {
      while (open.length && open.at(-1).column > column) open.pop();
      const top = open.at(-1);
      if (top && top.column === column && top.index !== undefined) top.index += 1;
      else open.push({ column, index: 0 });
      column += Math.max(match[0].length, 2);
      remainder = remainder.slice(match[0].length);
    }
    while (open.length && open.at(-1).column >= column) open.pop();
    const match = KEY.exec(remainder);
    if (match) {
      const key = unquoted(match[1]);
      onKey(path(), key);
      open.push({ column, key });
    }
    const value = (match ? remainder.slice(match[0].length) : remainder).trimStart();
    if (/^[|>][+-]?\d?\s*(#.*)?$/.test(value) && !last) literal = column;
    else if (/^[{[]/.test(value)) {
      flow = read(newFlow(path()), value, onKey);
      if (last) return flow?.place() ?? null;
    } else if (last) {
      if (/(^|\s)#/.test(value)) return null;
      const word = value.replace(/^["']/, "");
      if (match && remainder === match[0]) return null; // right behind the colon
      return { path: path(), kind: match ? "value" : "key", word };
    }
  }
  return null;
}

function unquoted(key) {
  return /^["']/.test(key) ? key.slice(1, -1) : key;
}

// What is written with brackets: its levels, and the word that is begun in the innermost.
function newFlow(base) {
  return {
    levels: [], // {map, key} or {map, index}
    word: "",
    inComment: false,
    place() {
      const inner = this.levels.at(-1);
      if (this.inComment) return null;
      const outer = [...base, ...this.levels.slice(0, -1).map((level) => level.key ?? level.index)];
      const word = this.word.trimStart();
      if (!inner.map) return { path: [...outer, inner.index], kind: "value", word };
      if (inner.key === null) return { path: outer, kind: "key", word };
      return { path: [...outer, inner.key], kind: "value", word };
    },
  };
}

// Reads a line of it; returns null where the last bracket is closed.
function read(flow, line, onKey) {
  const { levels } = flow;
  let quote = "";
  flow.inComment = false;
  for (let i = 0; i < line.length; i += 1) {
    const sign = line[i];
    const inner = levels.at(-1);
    if (quote) {
      if (sign === quote) quote = "";
      else flow.word += sign;
    } else if (/["']/.test(sign) && !flow.word.trim()) {
      quote = sign;
    } else if (/[{[]/.test(sign)) {
      levels.push(sign === "{" ? { map: true, key: null } : { map: false, index: 0 });
      flow.word = "";
    } else if (/[}\]]/.test(sign)) {
      levels.pop();
      flow.word = "";
      if (!levels.length) return null;
    } else if (sign === ",") {
      if (inner.map) inner.key = null;
      else inner.index += 1;
      flow.word = "";
    } else if (sign === ":" && inner.map && inner.key === null && /^(\s|$)/.test(line.slice(i + 1))) {
      onKey(flow.place().path, flow.word.trim());
      inner.key = flow.word.trim();
      flow.word = "";
    } else if (sign === "#" && /(^|\s)$/.test(line.slice(0, i))) {
      flow.inComment = true;
      return flow;
    } else flow.word += sign;
  }
  return flow;
}
