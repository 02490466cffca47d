"""What a file in TOML may say, key by key, as Markdown: written from the models that check it."""

from __future__ import annotations

import types
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal, get_args, get_origin

if TYPE_CHECKING:
    from pydantic import BaseModel

__all__ = ["about", "keys_table"]

_WORDS: dict[Any, str] = {str: "text", float: "number", int: "whole number", bool: "yes or no"}


def about(model: type[BaseModel]) -> str:
    """What a docstring "`[table]`: what it is" says, as a sentence; the rest of it follows as it is."""
    first, _, rest = (model.__doc__ or "").partition("\n\n")
    sentence = first.partition(": ")[2].strip().rstrip(".") + "."
    return "\n\n".join(filter(None, [sentence[:1].upper() + sentence[1:], " ".join(rest.split())]))


def keys_table(model: type[BaseModel], words: Mapping[Any, str], but: tuple[str, ...] = ()) -> str:
    """A line for each key of a table: what it may be, what it is where it is left out, what it means.

    Parameters
    ----------
    words : mapping       what to call types that are no text, number, or yes or no; `list` for one of whole numbers
    but : tuple of str    keys to pass over
    """
    lines = ["| key | value | left out | meaning |", "|---|---|---|---|"]
    for name, field in model.model_fields.items():
        if name not in but:
            default = "" if field.default is None or field.is_required() else f"`{_toml(field.default)}`"
            meaning = (field.description or "").replace("(not yet)", "(*not yet*)")
            lines.append(f"| `{name}` | {_kind(field.annotation, {**_WORDS, **words})} | {default} | {meaning} |")
    return "\n".join(lines)


def _toml(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else str(value)


def _kind(annotation: Any, words: Mapping[Any, str]) -> str:
    """A type in words."""
    origin = get_origin(annotation)
    if origin is Literal:
        return ", ".join(f'`"{choice}"`' for choice in get_args(annotation))
    if hasattr(annotation, "__metadata__"):
        return _kind(get_args(annotation)[0], words)
    if origin is types.UnionType or str(origin) == "typing.Union":
        parts = [_kind(part, words) for part in get_args(annotation) if part is not type(None)]
        return " or ".join(dict.fromkeys(parts))
    if origin is list:
        part = _kind(get_args(annotation)[0], words)
        if list in words and part == words[int]:
            return words[list]
        return f"list of {part.replace('whole number or number', 'number')}s".replace("texts", "text")
    return words[origin or annotation]
