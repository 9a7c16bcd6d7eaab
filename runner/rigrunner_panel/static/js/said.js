// What the server says in English, in another language: the table of the language's file has an English sentence
// and its translation, by the part of the program that says it. The server knows one language alone.

const KINDS = {
  id: "\\S+",
  member: "[\\w-]+\\.[\\w.-]+",
  number: "[+\u2212-]?\\d[\\d.]*(?:e[+-]?\\d+)?",
  value: "[+\u2212-]?\\d[\\d.]*(?:e[+-]?\\d+)?(?: \\S+?)?",
  instrument: "[^;]+ \\([\\w-]+\\.[\\w.-]+\\)",
  article: "an?",
  said: ".+",
};
const OTHERS = "(?:(?!; ).)+?";
const PLACE = /\{([a-z]+)(\d*)\}/g;

// Advice of the command line ("instead.X.of") is said as it is followed on the screen ("instead.X"), in every language.
const INSTEAD = /^instead\.(.+)\.of$/;

// Returns what translates a text: a sentence that no pattern knows stays as it is. `number` shows a number with its unit.
export function translator(table, english, words, number = String) {
  const patterns = Object.values(table)
    .flatMap((room) => Object.entries(room).map(([sentence, into]) => pattern(sentence, into)))
    .concat(Object.keys(english).filter((key) => INSTEAD.test(key)).map((key) => ({ ...pattern(english[key], words[key.replace(/\.of$/, "")]), literal: Infinity })))
    .sort((one, other) => other.literal - one.literal);

  const ways = { said: (text) => say(text), name: (text) => whole(text) ?? text, number, value: number };

  function whole(text) {
    for (const { shape, into } of patterns) {
      const found = shape.exec(text);
      if (found) return into.replace(PLACE, (_, kind, place) => (ways[kind] ?? String)(found.groups[`${kind}${place}`]));
    }
    return null;
  }

  function say(text) {
    return whole(text) ?? text.split("; ").map((part) => whole(part) ?? part).join("; ");
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
  return { shape: new RegExp(`^${source}$`, "su"), into, literal };
}
