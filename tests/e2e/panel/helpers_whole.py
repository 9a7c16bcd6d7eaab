"""Unreadable parts of a page: too wide, cut off, broken within a word, or overlapping."""

from __future__ import annotations

import re

UNREADABLE = """() => {
    const problems = [];
    const words = (e) => `${e.tagName.toLowerCase()}.${e.className}: ${e.textContent.slice(0, 60)}`;
    const seen = (e) => {
        const { width, height } = e.getBoundingClientRect();
        return width > 1 && height > 1 && !e.closest('.visually-hidden, .cm-editor, iframe');
    };
    const box = (e) => {  // of the text, without its padding
        const range = document.createRange();
        range.selectNodeContents(e);
        return range.getBoundingClientRect();
    };
    const wide = document.documentElement.scrollWidth;
    if (wide > innerWidth) problems.push(`the page is ${wide} px wide`);
    const texts = 'h1, h2, h3, th, td, dt, dd, p, li, .chip, .mark, .nav-link, .holder,'
        + ' .readout *, .plot-title *';
    for (const e of document.querySelectorAll(texts)) {
        if (!seen(e) || !/hidden|clip/.test(getComputedStyle(e).overflow)) continue;
        if (e.scrollWidth > e.clientWidth + 1) problems.push(`cut off: ${words(e)}`);
    }
    for (const e of document.querySelectorAll('.button, .chip, .mark, .stop')) {
        if (!seen(e)) continue;
        const [inner, outer] = [box(e), e.getBoundingClientRect()];
        const fits = inner.left >= outer.left + 1 && inner.right <= outer.right - 1;
        if (!fits) problems.push(`out of its frame: ${words(e)}`);
    }
    const nodes = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (nodes.nextNode()) {
        const node = nodes.currentNode;
        if (/\\/\\S/.test(node.data) || !seen(node.parentElement)) continue;  // a path has no words
        for (const { 0: word, index } of node.data.matchAll(/[\\p{L}\\d\\u00ad]{4,}/gu)) {
            if (word.length >= 40 || word.includes('\\u00ad')) continue;  // a digest; hyphens
            const range = document.createRange();
            range.setStart(node, index);
            range.setEnd(node, index + word.length);
            const lines = new Set([...range.getClientRects()].map((rect) => Math.round(rect.top)));
            if (lines.size > 1) problems.push(`broken: ${word} of ${words(node.parentElement)}`);
        }
    }
    const texted = '.nav-link, .rig-name, .holder';
    const parts = document.querySelectorAll(`.bar :is(${texted}, .chip, .button, select, .stop)`);
    const bar = [...parts].filter(seen);
    const boxes = bar.map((e) => {
        const [inner, outer] = [box(e), e.getBoundingClientRect()];
        if (!e.matches(texted)) return outer;
        const { top, bottom } = inner;
        return { top, bottom, left: inner.left, right: Math.min(inner.right, outer.right) };
    });
    boxes.forEach((one, i) => boxes.slice(i + 1).forEach((other, j) => {
        const across = Math.min(one.right, other.right) - Math.max(one.left, other.left);
        const down = Math.min(one.bottom, other.bottom) - Math.max(one.top, other.top);
        if (across <= -2 || down <= 2) return;
        problems.push(`touch: ${words(bar[i])} | ${words(bar[i + 1 + j])}`);
    }));
    return problems;
}"""
"""A script that returns a list of unreadable parts, in words."""
WORDS = """() => {
    const seen = (e) => e.getClientRects().length && getComputedStyle(e).visibility !== 'hidden';
    const nodes = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    const texts = [];
    while (nodes.nextNode()) {
        const e = nodes.currentNode.parentElement;
        if (e.closest('script, style, .cm-editor')) continue;
        if (e.tagName === 'OPTION' || seen(e)) texts.push(nodes.currentNode.nodeValue.trim());
    }
    for (const name of ['title', 'aria-label', 'placeholder', 'alt'])
        for (const e of document.querySelectorAll(`[${name}]`)) texts.push(e.getAttribute(name));
    return texts.filter(Boolean);
}"""
"""A script that returns all texts of a page that a person reads or hears."""
_ENGLISH = re.compile(
    r"(?<![\w.])(the|is|of|and|to|no|not|with|for|from|this|that|are|by|must|expected|unknown|held|"
    r"when|cannot)(?![\w.])",
    re.IGNORECASE,
)


def english_of(texts: list[str], lab_texts: str) -> list[str]:
    """Return the texts with an English word, apart from texts of the lab's own files."""
    lines = {line.strip(" -'\"") for line in lab_texts.split("\n") if line.strip()}
    values = {line.partition(": ")[2].strip("'\"") for line in lines} | lines
    for value in sorted(values - {""}, key=len, reverse=True):
        if " " in value:
            texts = [text.replace(value, "") for text in texts]
    return sorted({text for text in texts if _ENGLISH.search(re.sub(r"\S*/\S*", "", text))})
