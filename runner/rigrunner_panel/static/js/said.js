// Translates English texts of the server. The language's file has English sentences and their translations, by the
// part of the program that prints them. The server itself knows only English.

const A_FORM = "(?:a text|a number|a whole number|true or false|a list|a mapping of names to values)";
const KINDS = {
  id: "\\S+",
  member: "[\\w-]+\\.[\\w.-]+",
  number: "[+\u2212-]?\\d[\\d.]*(?:e[+-]?\\d+)?",
  value: "[+\u2212-]?\\d[\\d.]*(?:e[+-]?\\d+)?(?: \\S+?)?",
  instrument: "[^;]+ \\([\\w-]+\\.[\\w.-]+\\)",
  corners: "[\\w-]+\\.[\\w.-]+ up to (?:(?!; ).)+",
  forms: `${A_FORM}(?: or ${A_FORM})+`,
  quantity: "(?:an? )?(?:pH|[a-z][a-z ]*)",
  said: ".+",
};
const LONGEST = 1000; // characters of a sentence
const A_SENTENCE = 3; // the fewest known characters: '{name}: {said}' is of one part
const NO_LIST = new Set(["none", "nothing"]);
const OTHERS = "(?:(?!; )[^\\n])+?";
const LABEL = /^[^{}]+ [^{}]+: \{said\}$/; // the text behind such a label is a sentence of its own
const PROBLEM = /^(\S+:\d+:\d+: (?:[\w.[\]-]+: )?)(.+)$/;
const PLACE = /\{([a-z]+)(\d*)\}/g;

// Advice of the command line ("instead.X.of") is said as it is followed on the screen ("instead.X"), in every language.
const INSTEAD = /^instead\.(.+)\.of$/;

// Returns a function that translates a text: a sentence without a pattern stays as it is. `number` shows a number with its unit.
export function translator({ quantities = {}, ...rooms }, english, words, number = String) {
  const patterns = Object.values(rooms)
    .flatMap((room) => Object.entries(room).map(([sentence, translation]) => pattern(sentence, translation)))
    .concat(Object.keys(english).filter((key) => INSTEAD.test(key)).map((key) => ({ ...pattern(english[key], words[key.replace(/\.of$/, "")]), literal: Infinity })))
    .sort((a, b) => b.literal - a.literal);

  const quantity = (text) => quantities[text.replace(/^an? /, "")];
  const ways = {
    said: (text) => say(text),
    name: (text) => matched(text) ?? text,
    got: (text) => (text.startsWith("'") ? text : matched(text) ?? joined(text, "and", String)), // what a file has in quotes stays as it is
    list: (text) => (NO_LIST.has(text) ? matched(text) ?? text : text),
    all: (text) => joined(text, "and", String),
    any: (text) => joined(text, "or", String),
    forms: (text) => joined(text, "or", say),
    corners: (text) => joined(text, "or", say),
    quantity, number, value: number,
  };

  function matched(text, least = 0) {
    for (const { shape, translation, literal } of patterns) {
      const match = literal >= least && shape.exec(text);
      if (match && Object.entries(match.groups ?? {}).every(([place, part]) => !place.startsWith("quantity") || quantity(part))) {
        return translation.replace(PLACE, (_, kind, place) => (ways[kind] ?? String)(match.groups[`${kind}${place}`]));
      }
    }
    return null;
  }

  function joined(text, word, way) {
    return text.split(` ${word} `).map((part) => way(part)).join(` ${matched(word) ?? word} `);
  }

  // A problem of a file in one line: '{place}: {field}: {message} ({hint})'.
  function problem(text) {
    for (let at = text.indexOf(" ("); at > 0 && text.endsWith(")"); at = text.indexOf(" (", at + 1)) {
      const translated = matched(text.slice(0, at));
      if (translated !== null) return `${translated} (${say(text.slice(at + 2, -1))})`;
    }
    return say(text);
  }

  // Words that a title begins with a capital.
  function titled(text) {
    const lower = text.charAt(0).toLowerCase() + text.slice(1);
    const translated = lower === text ? null : quantities[lower] ?? matched(lower, A_SENTENCE);
    return translated && translated.charAt(0).toUpperCase() + translated.slice(1);
  }

  // Sentences are separated by "; ", which may occur within a sentence too.
  function say(text) {
    if (text.includes("\n")) return text.split("\n").map(say).join("\n");
    const located = PROBLEM.exec(text);
    if (located) return located[1] + problem(located[2]);
    const parts = text.split("; ");
    const remainder = (count) => (count < parts.length ? `; ${say(parts.slice(count).join("; "))}` : "");
    for (const count of [parts.length, 4, 3, 2, 1]) {
      const translated = count > parts.length ? null : matched(parts.slice(0, count).join("; "), count > 1 ? A_SENTENCE : 0);
      if (translated !== null) return translated + remainder(count);
    }
    return (quantities[parts[0]] ?? titled(parts[0]) ?? parts[0]) + remainder(1); // the name of an axis may be that of a quantity
  }

  return say;
}

// The same for English, whose sentences stay as they are.
export function advice(english) {
  return translator({}, english, english);
}

function pattern(sentence, translation) {
  const parts = sentence.split(PLACE); // literal, kind, number, literal, ...
  let source = "";
  for (let i = 0; i < parts.length; i += 3) {
    source += parts[i].replace(/[\\^$.*+?()[\]{}|/]/g, "\\$&");
    if (i + 1 < parts.length) source += `(?<${parts[i + 1]}${parts[i + 2]}>${KINDS[parts[i + 1]] ?? OTHERS})`;
  }
  const literal = parts.filter((_, i) => i % 3 === 0).join("").length;
  return { shape: new RegExp(`^${source}$`, "su"), translation, literal: LABEL.test(sentence) ? LONGEST + literal : literal };
}
