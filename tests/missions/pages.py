"""An independent reader of HTML pages, for tests: what is open, what is fetched, what is shown."""

import re
from dataclasses import dataclass, field
from html.parser import HTMLParser

VOID = {"meta", "img", "br", "hr", "link", "input"}
ALONE = ("script", "link", "iframe", "object", "embed", "form", "base", "svg", "video", "audio", "a")


@dataclass
class Page(HTMLParser):
    """Reads a page, and asserts as it goes that every element is closed in order."""

    tags: list = field(default_factory=list)
    sources: list = field(default_factory=list)
    texts: list = field(default_factory=list)
    opened: list = field(default_factory=list)
    attributes: set = field(default_factory=set)

    def __post_init__(self):
        super().__init__(convert_charrefs=True)

    def handle_starttag(self, tag, attrs):
        names = [name for name, _ in attrs]
        assert len(set(names)) == len(names)
        self.tags.append((tag, dict(attrs)))
        self.attributes |= set(names)
        self.sources += [value for name, value in attrs if name in ("src", "href", "srcset", "action", "data")]
        if tag not in VOID:
            self.opened.append(tag)

    def handle_endtag(self, tag):
        assert self.opened.pop() == tag

    def handle_data(self, data):
        if self.opened and self.opened[-1] != "style":
            self.texts.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.texts).split())

    def count(self, tag: str, class_: str | None = None) -> int:
        return sum(each == tag and class_ in (None, attrs.get("class")) for each, attrs in self.tags)


def read_page(content: bytes) -> Page:
    """The page, once it is sure that it runs nothing and fetches nothing."""
    text = content.decode("utf-8")
    assert text.startswith("<!DOCTYPE html>")
    page = Page()
    page.feed(text)
    page.close()
    assert page.opened == []
    assert not {tag for tag, _ in page.tags} & set(ALONE)
    assert not any(name.startswith("on") or name == "style" for name in page.attributes)
    assert all(source.startswith("data:image/png;base64,") for source in page.sources)
    (style,) = re.findall("<style>(.*?)</style>", text, re.DOTALL)
    assert not re.search(r"url|@import|http", style)
    assert "default-src 'none'" in str(page.tags)
    return page
