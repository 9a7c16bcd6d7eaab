// The words of the screen, from a file per language.

const LANGUAGES = ["en", "de"];
const KEPT = "rigrunner.language";
let words = {};
let language = "en";

export async function loadTexts() {
  const kept = localStorage.getItem(KEPT);
  const wanted = kept ?? navigator.language.slice(0, 2);
  language = LANGUAGES.includes(wanted) ? wanted : "en";
  const answer = await fetch(`/texts/${language}.json`);
  words = await answer.json();
  document.documentElement.lang = language;
}

// The text of that key, with {names} filled in; a key without a text shows itself.
export function t(key, values = {}) {
  const text = words[key] ?? key;
  return text.replace(/\{(\w+)\}/g, (whole, name) => String(values[name] ?? whole));
}

export function has(key) {
  return key in words;
}

export function languages() {
  return { all: LANGUAGES, now: language };
}

export function chooseLanguage(chosen) {
  localStorage.setItem(KEPT, chosen);
  location.reload();
}
