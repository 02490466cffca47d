"""XML as a tree, within limits: no document type, no entities of its own, not deep, not large."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from sooner.errors import DataFormatError
from sooner.io.vectors.feature import refusal

__all__ = ["Element", "parsed"]

DEEPEST = 64
MOST_ELEMENTS = 2_000_000


@dataclass
class Element:
    """An element: its name without a namespace, what it says, what stands in it."""

    tag: str
    attributes: dict[str, str]
    parts: list[Element] = field(default_factory=list)
    words: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """What it says, without blanks around it."""
        return "".join(self.words).strip()

    def all(self, *tags: str) -> Iterator[Element]:
        """Those right below it with one of these names."""
        return (part for part in self.parts if part.tag in tags)

    def said(self, tag: str) -> str:
        """What the first element of this name right below it says, "" where there is none."""
        return next((part.text for part in self.all(tag)), "")

    def below(self, *tags: str) -> Iterator[Element]:
        """Those of these names anywhere below it, in the file's order, not within one another."""
        for part in self.parts:
            if part.tag in tags:
                yield part
            else:
                yield from part.below(*tags)


def parsed(path: Path, data: bytes, expected: str) -> Element:
    """The root of a file in XML, of any encoding that says so itself.

    Raises
    ------
    DataFormatError         not XML, too deep, too many elements, or a document type came (which can name entities)
    """
    root = Element("", {})
    open_ones = [root]
    count = 0

    def refuse(came: str) -> DataFormatError:
        return refusal(path, f"line {parser.CurrentLineNumber}", came, expected)

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        if len(open_ones) > DEEPEST or count > MOST_ELEMENTS:
            raise refuse(f"more than {DEEPEST} elements in one another, or {MOST_ELEMENTS:,} in all, came")
        element = Element(name.rpartition("}")[2], attributes)
        open_ones[-1].parts.append(element)
        open_ones.append(element)

    def end(_: str) -> None:
        open_ones.pop()

    def words(text: str) -> None:
        open_ones[-1].words.append(text)

    def document_type(*_: object) -> None:
        raise refuse("a document type (<!DOCTYPE) came, which is not read")

    parser = expat.ParserCreate(namespace_separator="}")
    parser.buffer_text = True
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler = words
    parser.StartDoctypeDeclHandler = document_type
    parser.EntityDeclHandler = document_type
    try:
        parser.Parse(data, True)
    except (expat.ExpatError, ValueError, LookupError) as error:
        if isinstance(error, DataFormatError):
            raise
        raise refusal(path, "", f"it is not XML ({error})"[:200], expected) from None
    return root.parts[0]
