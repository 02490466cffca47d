"""XML in plain text: elements whose texts and attributes are only ever text, whatever they hold."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

__all__ = ["DECLARATION", "branch", "document", "empty", "leaf"]

DECLARATION = '<?xml version="1.0" encoding="UTF-8"?>'
_UNKNOWN = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # what XML 1.0 has no way to say
_NAMES = {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\t": "&#9;", "\n": "&#10;", "\r": "&#13;"}
_SPECIAL = re.compile('[&<>"\t\n\r]')


def _text(said: object) -> str:
    """Text for an element or an attribute; characters that XML cannot hold become U+FFFD."""
    known = _UNKNOWN.sub("\ufffd", str(said))
    return _SPECIAL.sub(lambda found: _NAMES[found.group()], known)


def _opening(tag: str, attributes: Mapping[str, object] | None) -> str:
    return tag + "".join(f' {name}="{_text(value)}"' for name, value in (attributes or {}).items())


def leaf(tag: str, said: object, attributes: Mapping[str, object] | None = None) -> str:
    """An element that holds text.

    >>> leaf("name", "<script> & more")
    '<name>&lt;script&gt; &amp; more</name>'
    """
    return f"<{_opening(tag, attributes)}>{_text(said)}</{tag}>"


def empty(tag: str, attributes: Mapping[str, object]) -> str:
    """An element that holds nothing.

    >>> empty("link", {"uid": 'a"b'})
    '<link uid="a&quot;b"/>'
    """
    return f"<{_opening(tag, attributes)}/>"


def branch(tag: str, children: Iterable[str], attributes: Mapping[str, object] | None = None) -> str:
    """An element that holds elements, each on a line of its own."""
    return "\n".join([f"<{_opening(tag, attributes)}>", *children, f"</{tag}>"])


def document(root: str) -> bytes:
    """A whole XML file."""
    return f"{DECLARATION}\n{root}\n".encode()
