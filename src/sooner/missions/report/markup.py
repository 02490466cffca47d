"""HTML in plain text: elements whose texts and attributes are only ever text, whatever they hold."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Sequence
from html import escape

from sooner.errors import printable

__all__ = ["Html", "bullets", "element", "facts", "joined", "picture", "table"]

ON_ONE_PAGE = 30  # rows of a table that is not cut in two


class Html(str):
    """Markup that has been made here; every other text is escaped."""

    __slots__ = ()


def _shown(said: object) -> str:
    """Markup as it is, text escaped; characters that no page can hold are told by their numbers."""
    if isinstance(said, Html):
        return said
    return escape(printable(str(said).encode("utf-8", "backslashreplace").decode(), but="\n"))


def element(tag: str, *inside: object, **attributes: object) -> Html:
    """An element; `class_` is the attribute `class`.

    >>> element("p", "<b> & ", element("b", "more"), class_='a"b')
    '<p class="a&quot;b">&lt;b&gt; &amp; <b>more</b></p>'
    """
    told = "".join(f' {name.rstrip("_")}="{_shown(value)}"' for name, value in attributes.items())
    return Html(f"<{tag}{told}>{''.join(_shown(each) for each in inside)}</{tag}>")


def joined(parts: Iterable[object]) -> Html:
    """One after the other, each on a line of its own."""
    return Html("\n".join(_shown(each) for each in parts))


def bullets(said: Sequence[object], **attributes: object) -> Html:
    """A list; nothing at all where there is nothing to say."""
    return element("ul", *(element("li", each) for each in said), **attributes) if said else Html()


def facts(said: Iterable[tuple[str, object]]) -> Html:
    """What is known by name: a table of two columns."""
    rows = (element("tr", element("th", name, scope="row"), element("td", value)) for name, value in said)
    return element("table", element("tbody", *rows), class_="facts")


def table(head: Sequence[object], rows: Sequence[Sequence[object]], caption: str = "") -> Html:
    """A table whose first column is text and whose others are numbers."""
    told = [element("caption", caption)] if caption else []
    heads = element("thead", element("tr", *(element("th", each, scope="col") for each in head)))
    body = element("tbody", *(element("tr", *(element("td", each) for each in row)) for row in rows))
    kept = "wide whole" if len(rows) <= ON_ONE_PAGE else "wide"
    return element("div", element("table", *told, heads, body, class_="numbers"), class_=kept)


def picture(png: bytes, says: str) -> Html:
    """A picture within the page, and what it shows for those who cannot see it."""
    source = Html("data:image/png;base64," + b64encode(png).decode())
    return Html(f'<figure><img src="{source}" alt="{_shown(says)}"></figure>')
