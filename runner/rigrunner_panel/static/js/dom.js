// Elements from code: every text is set as text, so that no value is ever taken for HTML.

export function h(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "class") element.className = value;
    else if (name === "value") element.value = value;
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

export function fill(element, ...children) {
  element.replaceChildren(...children.flat().filter((child) => child !== null && child !== undefined));
}

// The name of a file or a run, which is broken between its parts rather than within one.
export function breakable(name) {
  return name.split(/(?<=[/_])/).flatMap((part, i) => (i ? [h("wbr"), part] : [part]));
}

export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

export function show(element, visible) {
  if (element.hidden === visible) element.hidden = !visible;
}

// Returns a function for each key of a field: it calls `work` once nothing is typed any more for that time.
export function afterTyping(work, ms) {
  let timer = 0;
  return () => {
    clearTimeout(timer);
    timer = setTimeout(work, ms);
  };
}

export function button(text, onclick, { kind = "", key = "", ...rest } = {}) {
  const label = h("span", {}, text);
  const hint = key ? [h("kbd", { "aria-hidden": "true" }, key)] : [];
  return h("button", { type: "button", class: `button ${kind}`.trim(), onclick, ...rest }, label, ...hint);
}
