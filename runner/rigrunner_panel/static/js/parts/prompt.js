// A question of the run, over the page but below the bar, so that Stop stays in reach.

import { button, fill, h } from "../dom.js";
import { typedNumber } from "../format.js";
import { field } from "./field.js";
import { refusedWords } from "./notices.js";
import { steer, steerOrRefuse } from "../steer.js";
import { store } from "../store.js";
import { translate, t } from "../texts.js";

function stepOf(path) {
  if (path.startsWith("inputs.")) return t("prompt.input");
  const steps = store.state.plan?.steps ?? [];
  const at = steps.findIndex((step) => step.path === path);
  return at < 0 ? path : t("prompt.step", { at: at + 1, of: steps.length });
}

export function promptCard() {
  const element = h("div", { class: "prompt-cover", hidden: true });
  let shown = null;

  // The second click of a double click is of the question before: it answers no other one.
  function answer(text, event) {
    const { prompt } = store.state;
    if (prompt && event.detail < 2) steer("run/answer", { prompt: prompt.id, text });
  }

  function build(prompt) {
    const picture = prompt.picture ? h("img", { class: "prompt-picture", src: prompt.picture, alt: t("prompt.picture") }) : null;
    const card = h("section", { class: "prompt", role: "dialog", tabindex: "-1", "aria-labelledby": "prompt-text" },
      h("span", { class: "soft" }, [stepOf(prompt.step), store.state.job?.inputs.specimen].filter(Boolean).join(" · ")), h("p", { id: "prompt-text", class: "prompt-text" }, translate(prompt.text)), picture,
      prompt.choices.length ? choices(prompt) : typed(prompt));
    fill(element, card);
    // not on a button: the Enter of a scanner, which is a keyboard, would answer
    (card.querySelector("input") ?? card).focus();
  }

  function choices(prompt) {
    const label = (word) => (prompt.kind === "confirm" ? t(`prompt.${word}`) : word);
    return h("div", { class: "prompt-buttons" }, prompt.choices.map((word, i) => button(label(word), (event) => answer(word, event), { kind: i ? "huge" : "huge primary" })));
  }

  // What is refused is fixed where it stands.
  function typed(prompt) {
    const input = h("input", { type: "text", id: "prompt-input", autocomplete: "off" });
    const answerField = field(translate(prompt.text), input, { hint: translate(prompt.expected) || prompt.unit, kind: "prompt-field" });
    return h("form", { class: "prompt-form", onsubmit: async (event) => {
      event.preventDefault();
      try {
        await steerOrRefuse("run/answer", { prompt: prompt.id, text: prompt.unit ? typedNumber(input.value) : input.value });
      } catch (error) {
        answerField.refuse(refusedWords(error));
        input.focus();
      }
    } }, answerField.element, h("button", { type: "submit", class: "button huge primary" }, t("prompt.send")));
  }

  return {
    element,
    update() {
      const { prompt } = store.state;
      if (prompt?.id === shown) return;
      shown = prompt?.id ?? null;
      element.hidden = !prompt;
      if (prompt) build(prompt);
      else fill(element);
    },
  };
}
