"""Adds what a run found to the file of known bugs."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from textwrap import indent

from reachtest.baseline.document import Document, Entry, dump, items, parse
from reachtest.baseline.gone import new_ones
from reachtest.baseline.place import match
from reachtest.errors import BadInput, Problem
from reachtest.files import write_whole
from reachtest.results import FoundBefore, Result


@dataclass(frozen=True)
class Note:
    """What is written beside every new entry."""

    reason: str
    author: str
    today: date
    expires: date | None


@dataclass(frozen=True)
class Update:
    """What changed in the file."""

    added: tuple[Entry, ...]
    removed: tuple[Entry, ...]
    kept: int


def update_baseline(
    file: Path, result: Result, note: Note, only: Sequence[str] = (), prune: bool = False
) -> Update:
    """Add to `file` the gating findings of a run that no entry in force accounts for, or those named in `only`.

    Entries that are there stay as they are, comments and all. `prune` removes those that expired and those that
    the run shows to be fixed; comments are lost then. Raises BadInput.
    """
    level = result.report.level.name
    text = _text(file)
    document = parse(text, str(file)) if text else Document(version=1, level=level)
    if document.level != level:
        found = f"holds the known bugs of level {document.level!r}, the run was of {level!r}"
        raise BadInput([Problem(f"{file}: level", found, "give another --file for this level")])
    added = _added(document.entries, result, only, note)
    gone = _gone(document.entries, result, note.today) if prune else ()
    kept = tuple(entry for entry in document.entries if entry not in gone)
    if added or gone:
        _write(file, _with(text, document, kept, added))
    return Update(added, gone, len(kept))


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        return ""
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput([Problem(str(file), str(error), "give a --file that can be read")]) from error


def _chosen(result: Result, only: Sequence[str]) -> list[FoundBefore]:
    findings = result.report.findings
    if not only:
        return [finding for finding in findings if finding.gating]
    ids = [finding.id for finding in findings]
    if unknown := [id_ for id_ in only if id_ not in ids]:
        remedy = f"findings of that run: {', '.join(ids) or 'none'}"
        raise BadInput([Problem("command line: --only", f"no finding {id_!r}", remedy) for id_ in unknown])
    return [finding for finding in findings if finding.id in only]


def _added(entries: Sequence[Entry], result: Result, only: Sequence[str], note: Note) -> tuple[Entry, ...]:
    findings = _chosen(result, only)
    in_force = [entry.place for entry in entries if entry.in_force(note.today)]
    known = match([finding.place for finding in findings], in_force)
    fresh = [finding for finding, index in zip(findings, known, strict=True) if index is None]
    taken = {entry.id for entry in entries}
    added = []
    for finding in fresh:
        id_, count = finding.id, 1
        while id_ in taken:
            count += 1
            id_ = f"{finding.id}-{count}"
        taken.add(id_)
        added.append(_entry(finding, id_, note, result.report.level.sha256))
    return tuple(added)


def _entry(finding: FoundBefore, id_: str, note: Note, level_sha256: str) -> Entry:
    return Entry(
        id=id_,
        kind=finding.kind,
        title=finding.title,
        source_position=finding.source_position,
        position=finding.position,
        bounds=finding.bounds,
        exits=finding.known_exits,
        reason=note.reason,
        author=note.author,
        added=note.today,
        level_sha256=level_sha256,
        expires=note.expires,
    )


def _gone(entries: Sequence[Entry], result: Result, today: date) -> tuple[Entry, ...]:
    """The entries that expired, and those of bugs that the run shows to be fixed."""
    places = tuple(finding.place for finding in result.report.findings)
    in_force = [entry for entry in entries if entry.in_force(today)]
    seen = match(places, [entry.place for entry in in_force])
    look = result.report.look(places, new_ones(places, seen))
    absent = [entry for i, entry in enumerate(in_force) if i not in seen]
    fixed = [
        entry
        for entry in absent
        if look.worse(entry.place) is None and not look.doubt(entry.place, entry.level_sha256)
    ]
    return tuple(entry for entry in entries if entry in fixed or not entry.in_force(today))


_FIRST = re.compile(r"^( *)- ", re.MULTILINE)  # entry: its fellows stand below it


def _with(text: str, document: Document, kept: tuple[Entry, ...], added: tuple[Entry, ...]) -> str:
    """The new text: what stands there with the new entries below, if that is what it then says."""
    if document.entries and kept == document.entries:
        first = _FIRST.search(text)
        longer = text.rstrip("\n") + "\n" + indent(items(added), first[1] if first else "")
        try:
            if parse(longer, "").entries == kept + added:
                return longer
        except BadInput:
            pass  # laid out in another way, such as in braces or with a key below the list
    return dump(document.level, kept + added)


def _write(file: Path, text: str) -> None:
    try:
        write_whole(file, lambda part: part.write_text(text, encoding="utf-8"))
    except OSError as error:
        found = f"'{file}' cannot be written: {error.strerror}"
        raise BadInput([Problem("command line: --file", found, "name a file that can be written")]) from error
