// The editor of a procedure: CodeMirror with what the schema knows, and with the problems of a check.

import {
  EditorState, EditorView, HighlightStyle, autocompletion, bracketMatching, closeBrackets, closeBracketsKeymap, completionKeymap, defaultKeymap, drawSelection, highlightActiveLine,
  highlightActiveLineGutter, highlightSpecialChars, history, historyKeymap, hoverTooltip, indentOnInput, keymap, lineNumbers, lintGutter, search, searchKeymap, setDiagnostics, snippet, syntaxHighlighting, tags, yaml,
} from "../../vendor/codemirror/codemirror.js";
import { h } from "../dom.js";
import { translate, t } from "../texts.js";
import { placeAt } from "./place.js";
import { explained, offered } from "./schema.js";

const WORD = /[\w.$-]/;
const PHRASES = ["Find", "Replace", "next", "previous", "all", "match case", "by word", "regexp", "replace all", "close", "Completions", "Diagnostics", "No diagnostics"];

const COLOURS = HighlightStyle.define([
  { tag: tags.propertyName, color: "var(--accent)", fontWeight: "600" },
  { tag: [tags.string, tags.content], color: "var(--ink)" },
  { tag: tags.comment, color: "var(--ink-soft)", fontStyle: "italic" },
  { tag: [tags.punctuation, tags.separator, tags.squareBracket, tags.brace], color: "var(--ink-soft)" },
  { tag: [tags.keyword, tags.meta], color: "var(--warn)" },
]);

const LOOKS = EditorView.theme({
  "&": { height: "100%", fontSize: "15px", color: "var(--ink)", backgroundColor: "var(--surface)" },
  "&.cm-focused": { outline: "3px solid var(--focus)", outlineOffset: "-3px" },
  ".cm-scroller": { fontFamily: 'ui-monospace, "DejaVu Sans Mono", monospace', lineHeight: "1.5" },
  ".cm-content": { caretColor: "var(--ink)", padding: "8px 0" },
  ".cm-cursor": { borderLeftColor: "var(--ink)", borderLeftWidth: "2px" },
  ".cm-gutters": { color: "var(--ink-soft)", backgroundColor: "var(--surface-2)", borderRight: "1px solid var(--line)" },
  ".cm-activeLine, .cm-activeLineGutter": { backgroundColor: "color-mix(in srgb, var(--accent) 9%, transparent)" },
  "&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground, .cm-selectionBackground": { backgroundColor: "color-mix(in srgb, var(--accent) 30%, transparent)" },
  ".cm-tooltip": { color: "var(--ink)", backgroundColor: "var(--surface)", border: "1px solid var(--ink-soft)", borderRadius: "6px", maxWidth: "30rem" },
  ".cm-tooltip.cm-tooltip-autocomplete > ul > li": { padding: "4px 8px", fontFamily: "inherit" },
  ".cm-tooltip.cm-tooltip-autocomplete > ul > li[aria-selected]": { color: "var(--accent-ink)", backgroundColor: "var(--accent)" },
  ".cm-tooltip.cm-completionInfo": { padding: "8px", fontFamily: "system-ui, sans-serif" },
  ".cm-help": { padding: "8px", fontFamily: "system-ui, sans-serif" },
  ".cm-diagnostic": { fontFamily: "system-ui, sans-serif", borderLeftColor: "var(--bad)" },
  ".cm-panels": { color: "var(--ink)", backgroundColor: "var(--surface-2)" },
  ".cm-panel.cm-search input, .cm-panel.cm-search button": { fontSize: "15px", color: "var(--ink)", backgroundColor: "var(--surface)", backgroundImage: "none" },
});

function doc(text) {
  return text.replaceAll("\r\n", "\n");
}

// Shows a text; `on` has changed(), called as it is typed, and save(). A shadow root has its styles:
// the page lets in none but its own files.
export function procedureEditor(text, { readOnly = false, changed = () => {}, save = () => {} } = {}) {
  const ending = text.includes("\r\n") ? "\r\n" : "\n";
  let schema = null;
  const host = h("div", { class: "editor" });
  const root = host.attachShadow({ mode: "open" });
  const view = new EditorView({ root, parent: root, state: EditorState.create({ doc: doc(text), extensions: [
    lineNumbers(), highlightActiveLineGutter(), highlightActiveLine(), highlightSpecialChars(), history(), drawSelection(), indentOnInput(), bracketMatching(), closeBrackets(), search({ top: true }), lintGutter(), yaml(),
    syntaxHighlighting(COLOURS), LOOKS, EditorView.lineWrapping,
    EditorState.readOnly.of(readOnly), EditorState.tabSize.of(2),
    EditorState.phrases.of(Object.fromEntries(PHRASES.map((phrase) => [phrase, t(`editor.${phrase.toLowerCase().replaceAll(" ", "_")}`)]))),
    EditorView.contentAttributes.of({ "aria-label": t("editor.label"), spellcheck: "false", tabindex: "0" }),
    autocompletion({ override: [(context) => completions(schema, context)] }),
    hoverTooltip((shown, at) => help(schema, shown, at)),
    EditorView.updateListener.of((update) => update.docChanged && changed()),
    keymap.of([{ key: "Mod-s", preventDefault: true, run: () => save() || true }, ...closeBracketsKeymap, ...completionKeymap, ...defaultKeymap, ...historyKeymap, ...searchKeymap]),
  ] }) });
  return {
    element: host,
    text: () => view.state.doc.toString().replaceAll("\n", ending),
    replace: (replacement) => view.dispatch({ changes: { from: 0, to: view.state.doc.length, insert: doc(replacement) } }),
    setSchema: (newSchema) => {
      schema = newSchema;
    },
    mark: (problems) => view.dispatch(setDiagnostics(view.state, problems.filter((problem) => problem.line && !problem.file).map((problem) => diagnostic(view.state.doc, problem)))),
    goTo: ({ line, column }) => {
      const at = position(view.state.doc, line, column);
      view.dispatch({ selection: { anchor: at }, effects: EditorView.scrollIntoView(at, { y: "center" }) });
      view.focus();
    },
    leave: () => view.destroy(),
  };
}

function position(text, line, column) {
  const start = text.line(Math.min(Math.max(line, 1), text.lines));
  return Math.min(start.from + (column ?? 1) - 1, start.to);
}

function diagnostic(text, problem) {
  const from = position(text, problem.line, problem.column);
  const line = text.lineAt(from);
  const word = /^[^\s,{}[\]]+/.exec(line.text.slice(from - line.from))?.[0] ?? "";
  const message = [problem.field && `${problem.field}:`, translate(problem.message), problem.hint && `(${translate(problem.hint)})`].filter(Boolean).join(" ");
  return { from, to: Math.max(from + word.length, Math.min(from + 1, line.to)), severity: "error", message };
}

function completions(schema, context) {
  if (!schema) return null;
  const before = context.state.sliceDoc(0, context.pos);
  const place = placeAt(before);
  if (!place || !/^[\w.$-]*$/.test(place.word) || (!place.word && !context.explicit && place.kind === "key")) return null;
  const present = [];
  placeAt(context.state.doc.toString(), (path, key) => path.join("\n") === place.path.join("\n") && present.push(key));
  const line = context.state.doc.lineAt(context.pos);
  const isKeyThere = /^\s*:(\s|$)/.test(line.text.slice(context.pos - line.from)); // the key stands there: only its name is changed
  const options = offered(schema, place, present.filter((key) => key !== place.word)).map((offer) => option(offer, isKeyThere));
  return { from: context.pos - place.word.length, options, validFor: /^[\w.$-]*$/ };
}

function option(offer, isKeyThere) {
  const dash = offer.item ? "- " : "";
  if (offer.kind === "value") return { label: offer.label, type: "constant", info: offer.description || undefined, apply: `${dash}${offer.label}` };
  const needed = offer.needed.map((key) => `${key}: \${}`).join(", ");
  const written = isKeyThere ? offer.label : offer.inline ? `{${offer.label}: {${needed || "${}"}}}` : `${dash}${offer.label}: ${offer.isMapping ? `{${needed || "${}"}}` : "${}"}`;
  return { label: offer.label, displayLabel: `${offer.label}:`, type: "property", detail: offer.required ? t("editor.required") : undefined, info: offer.description || undefined, boost: offer.required ? 1 : 0, apply: isKeyThere ? written : snippet(written) };
}

function help(schema, view, at) {
  if (!schema) return null;
  const line = view.state.doc.lineAt(at);
  let from = at - line.from;
  let to = from;
  while (from > 0 && WORD.test(line.text[from - 1])) from -= 1;
  while (to < line.text.length && WORD.test(line.text[to])) to += 1;
  if (from === to) return null;
  const word = line.text.slice(from, to);
  const place = placeAt(view.state.sliceDoc(0, line.from + to));
  if (!place || place.word !== word) return null;
  const words = explained(schema, place, word);
  if (!words) return null;
  return { pos: line.from + from, end: line.from + to, above: true, create: () => ({ dom: h("div", { class: "cm-help" }, h("strong", {}, word), h("p", {}, words)) }) };
}
