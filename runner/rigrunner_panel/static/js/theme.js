// Light or dark, as the machine has it or as it was chosen; plots are notified of a change.

const STORAGE_KEY = "rigrunner.theme";
const listeners = new Set();
const darkMachine = matchMedia("(prefers-color-scheme: dark)");

export function themeNow() {
  return localStorage.getItem(STORAGE_KEY) ?? "auto";
}

export function applyTheme() {
  const chosen = themeNow();
  const machine = darkMachine.matches ? "dark" : "light";
  document.documentElement.dataset.theme = chosen === "auto" ? machine : chosen;
  for (const listener of [...listeners]) listener();
}

export function chooseTheme(name) {
  localStorage.setItem(STORAGE_KEY, name);
  applyTheme();
}

export function onTheme(listener) {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

export function watchTheme() {
  darkMachine.addEventListener("change", applyTheme);
}

export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}
