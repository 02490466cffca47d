"""XML read within limits: no document type, no entities of its own, not deep; told as it comes, or as a tree."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol
from xml.parsers import expat

from sooner.errors import DataFormatError, Fault

__all__ = ["Element", "Reader", "read_markup", "tree"]

DEEPEST = 64
MOST_TEXT = 64_000_000  # characters of one element
MOST_ELEMENTS = 2_000_000  # of a tree, which is kept whole


class Reader(Protocol):
    """Whoever is told of elements as they begin and end."""

    def begin(self, tag: str, attributes: Mapping[str, str]) -> None:
        """An element of this name, without its namespace, begins."""

    def end(self, tag: str, text: str) -> None:
        """It ends; its own text, without that of elements within, and without blanks around it."""


class _Refused(Exception):  # noqa: N818
    """What came that is not read."""


@dataclass
class _Open:
    """Elements that are open, each with its text so far."""

    reader: Reader
    texts: list[list[str]] = field(default_factory=list)
    characters: int = 0

    def begin(self, tag: str, attributes: Mapping[str, str]) -> None:
        if len(self.texts) == DEEPEST:
            raise _Refused(f"more than {DEEPEST} elements in one another came")
        self.texts.append([])
        self.characters = 0
        self.reader.begin(tag.rpartition(" ")[2], attributes)

    def text(self, said: str) -> None:
        self.characters += len(said)
        if self.characters > MOST_TEXT:
            raise _Refused("an element with an endless text came")
        self.texts[-1].append(said)

    def end(self, tag: str) -> None:
        self.reader.end(tag.rpartition(" ")[2], "".join(self.texts.pop()).strip())

    def refuse(self, *_: object) -> None:
        raise _Refused("a document type came (<!DOCTYPE), which may hold entities without end and is not read")


def read_markup(path: Path, data: bytes, reader: Reader, expected: str) -> None:
    """Tell a reader of every element of a file in XML, of any encoding that says so itself.

    Raises
    ------
    DataFormatError     not XML, too deep, or with a document type
    """
    opened = _Open(reader)
    parser = expat.ParserCreate(namespace_separator=" ")
    parser.buffer_text = True
    parser.StartElementHandler, parser.EndElementHandler = opened.begin, opened.end
    parser.CharacterDataHandler = opened.text
    parser.StartDoctypeDeclHandler = parser.EntityDeclHandler = opened.refuse
    try:
        parser.Parse(data, True)
    except _Refused as error:
        line = f"line {parser.CurrentLineNumber}"
        raise DataFormatError(Fault(str(path), line, str(error), expected)) from None
    except DataFormatError:
        raise
    except (expat.ExpatError, ValueError, LookupError) as error:  # the latter two: of encodings that nobody knows
        raise DataFormatError(Fault(str(path), "", f"it is not XML ({error})"[:200], expected)) from None


@dataclass
class Element:
    """An element of a tree: its name without a namespace, what it says, what stands in it."""

    tag: str
    attributes: Mapping[str, str]
    parts: list[Element] = field(default_factory=list)
    text: str = ""

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


class _Tree:
    """Keeps every element."""

    def __init__(self) -> None:
        self.open = [Element("", {})]
        self.count = 0

    def begin(self, tag: str, attributes: Mapping[str, str]) -> None:
        self.count += 1
        if self.count > MOST_ELEMENTS:
            raise _Refused(f"more than {MOST_ELEMENTS:,} elements came")
        element = Element(tag, attributes)
        self.open[-1].parts.append(element)
        self.open.append(element)

    def end(self, tag: str, text: str) -> None:
        self.open.pop().text = text


def tree(path: Path, data: bytes, expected: str) -> Element:
    """The root of a file in XML; errors as `read_markup`, and too many elements."""
    reader = _Tree()
    read_markup(path, data, reader, expected)
    return reader.open[0].parts[0]
