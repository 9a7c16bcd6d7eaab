// Numbers as people read them. Values come in SI units; an unknown one is shown as a dash.

export const UNKNOWN = "–";
let sign = ".";

// With which sign decimals are shown, as the language of the screen has it.
export function useDecimalSign(chosen) {
  sign = chosen;
}

// A number in a text, with the screen's decimal sign.
export function shownNumber(text) {
  return text.replace(/(\d)\.(?=\d)/g, `$1${sign}`);
}

// A text that may be a quantity: "22.5 °C" is shown as a number, "GE20.1" as it is.
export function shownQuantity(text) {
  return /^[+\u2212-]?\d[\d.]*(e[+-]?\d+)? \S+$/.test(text) ? shownNumber(text) : text;
}

// What a person typed, with the decimal point that the server reads.
export function typedNumber(text) {
  return sign === "," ? text.replace(/^(\s*[+\u2212-]?\d+),(?=\d)/, "$1.") : text;
}

// A list with the decimal points that the server reads, in its columns of `measured` names, which the first line with words
// says; where commas divide columns there are no decimal commas.
export function typedList(text, measured) {
  const lines = text.split("\n");
  const head = lines.findIndex((line) => line.trim() && !/^sep=.$/i.test(line.trim()));
  const separator = ["\t", ";"].find((separator) => lines[head]?.includes(separator));
  if (!separator) return text;
  const names = new Set([...measured].map((name) => name.toLowerCase()));
  const numbers = lines[head].split(separator).map((name) => names.has(name.trim().toLowerCase()));
  const read = (line) => line.split(separator).map((cell, i) => (numbers[i] ? typedNumber(cell.replace(/^(\s*)"([^"]*)"(\s*)$/, "$1$2$3")) : cell)).join(separator);
  return lines.map((line, i) => (i > head ? read(line) : line)).join("\n");
}

export function fixed(value, decimals) {
  if (value === null || value === undefined || !Number.isFinite(value)) return UNKNOWN;
  const text = value.toFixed(decimals);
  return shownNumber((Number(text) === 0 ? text.replace("-", "") : text).replace("-", "\u2212"));
}

// A set value as a person wrote it: 16.5, not 17; 35, not 35.0.
export function plain(value) {
  if (value === null || value === undefined || !Number.isFinite(value)) return UNKNOWN;
  return shownNumber(String(Number(value.toPrecision(6))).replace("-", "\u2212"));
}

// The limits of a value; "" where it has none.
export function limitText({ lower, upper }) {
  if (Number.isFinite(lower)) return Number.isFinite(upper) ? `${plain(lower)} … ${plain(upper)}` : `≥ ${plain(lower)}`;
  return Number.isFinite(upper) ? `≤ ${plain(upper)}` : "";
}

const MOST_DECIMALS = 20;

// The decimals that show an uncertainty with two significant digits (GUM 7.2.6); negative for tens
// and more.
export function decimalsFor(uncertainty, otherwise = 3) {
  if (!Number.isFinite(uncertainty) || uncertainty <= 0) return otherwise;
  const exponent = Math.floor(Math.log10(Number(uncertainty.toPrecision(2))));
  return Math.min(1 - exponent, MOST_DECIMALS);
}

export function withUncertainty(value, uncertainty, unit) {
  if (!Number.isFinite(value)) return UNKNOWN;
  if (!Number.isFinite(uncertainty)) return `${plain(value)} ${unit}`;
  const decimals = decimalsFor(uncertainty);
  const step = 10 ** -decimals;
  const shown = (number) => (decimals < 0 ? fixed(Math.round(number / step) * step, 0) : fixed(number, decimals));
  return `${shown(value)} ± ${shown(uncertainty)} ${unit}`;
}

function two(number) {
  return String(number).padStart(2, "0");
}

export function duration(seconds) {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return UNKNOWN;
  const total = Math.max(0, Math.round(seconds));
  const hours = Math.floor(total / 3600);
  const minutes = Math.floor(total / 60) % 60;
  return hours ? `${hours}:${two(minutes)}:${two(total % 60)}` : `${minutes}:${two(total % 60)}`;
}

export function bytes(count) {
  const units = ["B", "kB", "MB", "GB", "TB"];
  let value = count;
  let step = 0;
  while (value >= 1000 && step < units.length - 1) {
    value /= 1000;
    step += 1;
  }
  return `${fixed(value, value >= 100 || step === 0 ? 0 : 1)} ${units[step]}`;
}

// The time of day, to the second.
export function clock(utc) {
  const moment = new Date(utc);
  return Number.isNaN(moment.getTime()) ? utc : `${two(moment.getHours())}:${two(moment.getMinutes())}:${two(moment.getSeconds())}`;
}

export function localTime(utc) {
  if (!utc) return UNKNOWN;
  const moment = new Date(utc);
  if (Number.isNaN(moment.getTime())) return utc;
  const day = [moment.getFullYear(), two(moment.getMonth() + 1), two(moment.getDate())].join("-");
  return `${day} ${two(moment.getHours())}:${two(moment.getMinutes())}`;
}
