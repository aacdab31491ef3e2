"""Godot's text format: its sections, and the numbers in them.

Strings and comments are blanked out before anything is looked for: scripts within a scene may hold anything.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NoReturn, TypeVar

import numpy as np

from reachtest.levels.fields import FARTHEST
from reachtest.levels.meshes.scene import Unreadable
from reachtest.records import Floats

_DAMAGED = "the file is damaged or cut off: save it again in Godot"
_QUOTED = re.compile(r'"(?:[^"\\]|\\.)*"|;[^\n]*|"', re.DOTALL)
_NOT_BREAK = re.compile(r"[^\n]")
_HEADER = re.compile(
    r"^\[(gd_scene|gd_resource|ext_resource|sub_resource|resource|node|connection|editable)\b[^\n]*",
    re.MULTILINE,
)
_ATTRIBUTE = re.compile(r'\b(name|type|id|parent)=(?:"((?:[^"\\]|\\.)*)"|(\d+))')

Number = TypeVar("Number", int, float)


@dataclass(frozen=True)
class TextSection:
    """One `[...]` header and the properties below it."""

    kind: str
    attributes: dict[str, str]
    start: int
    end: int


def refuse_at(text: str, at: int, found: str) -> NoReturn:
    """Raise Unreadable for what was found at a place in the text."""
    raise Unreadable(f"{found} in line {text.count(chr(10), 0, at) + 1}", _DAMAGED)


def decode(data: bytes) -> str:
    """The text of a file. Raises Unreadable."""
    try:
        return data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        remedy = "save the resource as text (.tres or .tscn), not as binary (.res or .scn)"
        raise Unreadable(f"is no UTF-8 text in line {line}", remedy) from error


def masked_text(text: str) -> str:
    """The text with strings and comments blanked out: scripts within a scene may hold anything."""

    def blank(match: re.Match[str]) -> str:
        if match[0] == '"':
            refuse_at(text, match.start(), "has a string without an end, which starts")
        return _NOT_BREAK.sub(" ", match[0])  # places and line numbers stay

    return _QUOTED.sub(blank, text)


def sections_of(text: str, masked: str) -> Iterator[TextSection]:
    """The sections of a text that is also given without its strings and comments."""
    headers = list(_HEADER.finditer(masked))
    ends = [*(header.start() for header in headers[1:]), len(text)]
    for header, end in zip(headers, ends, strict=False):  # a file without headers has one end too many
        found = _ATTRIBUTE.findall(text, *header.span())
        yield TextSection(
            header[1], {key: quoted or number for key, quoted, number in found}, header.end(), end
        )


def read_numbers(text: str, at: int, pattern: re.Pattern[str], what: str) -> Floats:
    """The numbers in the parentheses that `pattern` finds at a place. Raises Unreadable."""
    match = pattern.match(text, at)
    if match is None:
        refuse_at(text, at, f"has {what} without an end or of an unknown type")
    return np.array(parse_numbers(text, match, float, what), dtype=np.float64)


def parse_numbers(text: str, match: re.Match[str], to: type[Number], what: str) -> list[Number]:
    """The numbers in the parentheses of `match`, each of them near enough to be one."""
    numbers, at = [], match.start(1)
    words = match[1].split(",") if match[1].strip() else []
    for word in words:
        start = at + len(word) - len(word.lstrip())
        try:
            number = to(word)
        except ValueError:
            refuse_at(text, start, f"has {what} with {word.strip()[:40]!r}, which is no number,")
        if not abs(number) <= FARTHEST:
            refuse_at(text, start, f"has {what} with {word.strip()[:40]}, NaN, infinite or too far away,")
        numbers.append(number)
        at += len(word) + 1
    return numbers
