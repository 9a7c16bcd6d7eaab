// The words of the screen, from a file per language.

import { shownNumber, useDecimalSign } from "./format.js";
import { advice, translator } from "./said.js";

const LANGUAGES = ["en", "de"];
const DECIMAL_SIGNS = { en: ".", de: "," };
const KEPT = "rigrunner.language";
let words = {};
let say = (text) => text;

export async function loadTexts() {
  const kept = localStorage.getItem(KEPT);
  const wanted = kept ?? navigator.language.slice(0, 2);
  const language = LANGUAGES.includes(wanted) ? wanted : "en";
  words = await fetched(language);
  useDecimalSign(DECIMAL_SIGNS[language]);
  say = language === "en" ? advice(words) : translator(await fetched(`said.${language}`), await fetched("en"), words, shownNumber);
  document.documentElement.lang = language;
}

async function fetched(name) {
  return (await fetch(`/texts/${name}.json`)).json();
}

// What the server said in English, in the language of the screen.
export function said(text) {
  return text ? say(text) : text;
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
  return { all: LANGUAGES, now: document.documentElement.lang };
}

export function chooseLanguage(chosen) {
  localStorage.setItem(KEPT, chosen);
  location.reload();
}
