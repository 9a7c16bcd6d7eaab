"""Reads an HTML page for tests: its elements in order, and its visible text."""

from __future__ import annotations

from dataclasses import dataclass, field
from html.parser import HTMLParser

VOID = {"meta", "img", "br", "link", "input", "hr"}


@dataclass
class Page(HTMLParser):
    """Elements as (tag, attributes), text without styles and scripts; wrong nesting is an error."""

    elements: list = field(default_factory=list)
    text: list = field(default_factory=list)
    open_tags: list = field(default_factory=list)

    def __post_init__(self):
        super().__init__(convert_charrefs=True)

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open_tags.append(tag)

    def handle_endtag(self, tag):
        assert self.open_tags.pop() == tag, f"</{tag}> closes another element"

    def handle_data(self, data):
        if not {"style", "script"} & set(self.open_tags):
            self.text.append(data)

    def all(self, tag):
        """Return the attributes of every element of that tag."""
        return [attributes for name, attributes in self.elements if name == tag]

    @property
    def words(self):
        """Return all text with single blanks."""
        return " ".join(" ".join(self.text).split())


def read_html(data: bytes) -> Page:
    page = Page()
    page.feed(data.decode("utf-8"))
    page.close()
    assert page.open_tags == []
    return page
