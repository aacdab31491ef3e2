"""Is there a file of that name, and what would be right if not."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from reachtest.levels.fields import nearest


def file_problem(
    name: str, folder: Path, readers: Collection[str], what_for: str = "mesh", typed: bool = True
) -> tuple[str, str] | None:
    """What is wrong with the file's name, and the remedy; None where it can be read.

    Of a file that is `typed`, the suffix must be one of `readers`.
    """
    path = folder / name
    if typed and path.suffix.lower() not in readers:
        what = f"of type {path.suffix!r}" if path.suffix else "without a type"
        return f"{name} is a file {what}", f"export it as one of {' '.join(sorted(readers))}"
    if path.is_file():
        return None
    if path.exists():
        return f"{name} is not a file", f"name the {what_for} file itself"
    if not path.parent.is_dir():
        return (
            f"{name} does not exist: there is no folder {Path(name).parent}",
            f"paths start at {folder.name}/",
        )
    names = sorted(other.name for other in path.parent.iterdir())
    near = nearest(path.name, names)
    valid = [other for other in names if Path(other).suffix.lower() in readers]
    there = f"{what_for} files there: {', '.join(valid[:8]) or 'none'}"
    return f"{name} does not exist", f"{near}{there}"
