"""Arguments that several commands take."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

LevelFile = Annotated[Path, typer.Argument(metavar="LEVEL.yaml", help="The level file.")]
ConfigFile = Annotated[
    Path | None,
    typer.Option("--config", metavar="FILE", help="Sections explore and gate that win over the level's."),
]
