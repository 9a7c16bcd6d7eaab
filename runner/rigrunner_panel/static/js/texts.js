// The words of the screen, from a file per language.

import { shownNumber, useDecimalSign } from "./format.js";
import { advice, translator } from "./said.js";

const LANGUAGES = ["en", "de"];
const DECIMAL_SIGNS = { en: ".", de: "," };
const STORAGE_KEY = "rigrunner.language";
let words = {};
let say = (text) => text;

export async function loadTexts() {
  const stored = localStorage.getItem(STORAGE_KEY);
  const preferred = stored ?? navigator.language.slice(0, 2);
  const language = LANGUAGES.includes(preferred) ? preferred : "en";
  words = await fetchTexts(language);
  useDecimalSign(DECIMAL_SIGNS[language]);
  say = language === "en" ? advice(words) : translator(await fetchTexts(`said.${language}`), await fetchTexts("en"), words, shownNumber);
  document.documentElement.lang = language;
}

async function fetchTexts(name) {
  return (await fetch(`/texts/${name}.json`)).json();
}

// An English text of the server in the language of the screen.
export function translate(text) {
  return text ? say(text) : text;
}

// The text of that key, with {names} filled in; a key without a text shows itself.
export function t(key, values = {}) {
  const text = words[key] ?? key;
  return text.replace(/\{(\w+)\}/g, (placeholder, name) => String(values[name] ?? placeholder));
}

export function has(key) {
  return key in words;
}

export function languages() {
  return { all: LANGUAGES, now: document.documentElement.lang };
}

export function chooseLanguage(chosen) {
  localStorage.setItem(STORAGE_KEY, chosen);
  location.reload();
}
