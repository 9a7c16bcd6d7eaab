// What the server says in English, in another language: the table of the language's file has an English sentence
// and its translation, by the part of the program that says it. The server knows one language alone.

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
const LABEL = /^[^{}]+ [^{}]+: \{said\}$/; // what is said behind such a label is a sentence of its own
const PROBLEM = /^(\S+:\d+:\d+: (?:[\w.[\]-]+: )?)(.+)$/;
const PLACE = /\{([a-z]+)(\d*)\}/g;

// Advice of the command line ("instead.X.of") is said as it is followed on the screen ("instead.X"), in every language.
const INSTEAD = /^instead\.(.+)\.of$/;

// Returns what translates a text: a sentence that no pattern knows stays as it is. `number` shows a number with its unit.
export function translator({ quantities = {}, ...rooms }, english, words, number = String) {
  const patterns = Object.values(rooms)
    .flatMap((room) => Object.entries(room).map(([sentence, into]) => pattern(sentence, into)))
    .concat(Object.keys(english).filter((key) => INSTEAD.test(key)).map((key) => ({ ...pattern(english[key], words[key.replace(/\.of$/, "")]), literal: Infinity })))
    .sort((one, other) => other.literal - one.literal);

  const quantity = (text) => quantities[text.replace(/^an? /, "")];
  const ways = {
    said: (text) => say(text),
    name: (text) => whole(text) ?? text,
    got: (text) => (text.startsWith("'") ? text : whole(text) ?? joined(text, "and", String)), // what a file has in quotes stays as it is
    list: (text) => (NO_LIST.has(text) ? whole(text) ?? text : text),
    all: (text) => joined(text, "and", String),
    any: (text) => joined(text, "or", String),
    forms: (text) => joined(text, "or", say),
    corners: (text) => joined(text, "or", say),
    quantity, number, value: number,
  };

  function whole(text, least = 0) {
    for (const { shape, into, literal } of patterns) {
      const found = literal >= least && shape.exec(text);
      if (found && Object.entries(found.groups ?? {}).every(([place, part]) => !place.startsWith("quantity") || quantity(part))) {
        return into.replace(PLACE, (_, kind, place) => (ways[kind] ?? String)(found.groups[`${kind}${place}`]));
      }
    }
    return null;
  }

  function joined(text, word, way) {
    return text.split(` ${word} `).map((part) => way(part)).join(` ${whole(word) ?? word} `);
  }

  // A problem of a file in one line: '{place}: {field}: {message} ({hint})'.
  function problem(text) {
    for (let at = text.indexOf(" ("); at > 0 && text.endsWith(")"); at = text.indexOf(" (", at + 1)) {
      const told = whole(text.slice(0, at));
      if (told !== null) return `${told} (${say(text.slice(at + 2, -1))})`;
    }
    return say(text);
  }

  // Words that a title begins with a capital.
  function titled(text) {
    const own = text.charAt(0).toLowerCase() + text.slice(1);
    const told = own === text ? null : quantities[own] ?? whole(own, A_SENTENCE);
    return told && told.charAt(0).toUpperCase() + told.slice(1);
  }

  // Sentences stand behind each other with "; " between them, which may be within a sentence too.
  function say(text) {
    if (text.includes("\n")) return text.split("\n").map(say).join("\n");
    const placed = PROBLEM.exec(text);
    if (placed) return placed[1] + problem(placed[2]);
    const parts = text.split("; ");
    const rest = (count) => (count < parts.length ? `; ${say(parts.slice(count).join("; "))}` : "");
    for (const count of [parts.length, 4, 3, 2, 1]) {
      const told = count > parts.length ? null : whole(parts.slice(0, count).join("; "), count > 1 ? A_SENTENCE : 0);
      if (told !== null) return told + rest(count);
    }
    return (quantities[parts[0]] ?? titled(parts[0]) ?? parts[0]) + rest(1); // the name of an axis may be that of a quantity
  }

  return say;
}

// The same for English, whose sentences stay as they are.
export function advice(english) {
  return translator({}, english, english);
}

function pattern(sentence, into) {
  const parts = sentence.split(PLACE); // literal, kind, number, literal, ...
  let source = "";
  for (let i = 0; i < parts.length; i += 3) {
    source += parts[i].replace(/[\\^$.*+?()[\]{}|/]/g, "\\$&");
    if (i + 1 < parts.length) source += `(?<${parts[i + 1]}${parts[i + 2]}>${KINDS[parts[i + 1]] ?? OTHERS})`;
  }
  const literal = parts.filter((_, i) => i % 3 === 0).join("").length;
  return { shape: new RegExp(`^${source}$`, "su"), into, literal: LABEL.test(sentence) ? LONGEST + literal : literal };
}
