"""XML read as it comes: elements with their texts, and no entities, so that a small file stays small."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol
from xml.parsers import expat

from sooner.errors import DataFormatError
from sooner.io.reading import bytes_of
from sooner.io.tracks.fixes import refusal

__all__ = ["Reader", "read_markup"]

MOST_BYTES = 200_000_000
MOST_DEPTH = 100
MOST_TEXT = 64_000_000  # characters of one element


class Reader(Protocol):
    """Whoever is told of elements as they begin and end."""

    def begin(self, tag: str, attributes: Mapping[str, str]) -> None:
        """An element of this name, without its namespace, begins."""

    def end(self, tag: str, text: str) -> None:
        """It ends; its own text, without that of elements within."""


@dataclass
class _Open:
    """Elements that are open, each with its text so far."""

    path: Path
    reader: Reader
    texts: list[list[str]] = field(default_factory=list)
    characters: int = 0

    def begin(self, tag: str, attributes: Mapping[str, str]) -> None:
        if len(self.texts) == MOST_DEPTH:
            raise refusal(self.path, "", f"elements within more than {MOST_DEPTH} others came", "expected a track")
        self.texts.append([])
        self.characters = 0
        self.reader.begin(tag.rpartition(" ")[2], attributes)

    def text(self, said: str) -> None:
        if self.texts:
            self.characters += len(said)
            if self.characters > MOST_TEXT:
                raise refusal(self.path, "", "an element with an endless text came", "expected a track")
            self.texts[-1].append(said)

    def end(self, tag: str) -> None:
        self.reader.end(tag.rpartition(" ")[2], "".join(self.texts.pop()).strip())

    def refuse(self, *declared: object) -> None:
        raise refusal(
            self.path, "", "a document type came, which may hold entities without end", "expected XML without one"
        )


def read_markup(path: Path, reader: Reader, expected: str) -> None:
    """Tell a reader of every element of an XML file.

    Raises
    ------
    DataFormatError     missing, larger than 200 MB, not XML, or with a document type
    """
    data = bytes_of(path, MOST_BYTES, "200 MB", expected)
    opened = _Open(path, reader)
    parser = expat.ParserCreate(namespace_separator=" ")
    parser.buffer_text = True
    parser.StartElementHandler = opened.begin
    parser.EndElementHandler = opened.end
    parser.CharacterDataHandler = opened.text
    parser.StartDoctypeDeclHandler = opened.refuse
    try:
        parser.Parse(data, True)
    except DataFormatError:
        raise
    except (expat.ExpatError, ValueError, LookupError) as error:  # the latter two: of encodings that nobody knows
        raise refusal(path, "", f"it is not XML ({error})", expected) from None
