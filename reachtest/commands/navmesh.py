"""`reachtest navmesh`: nav-meshes, without exploring anything."""

from __future__ import annotations

import enum
from pathlib import Path
from typing import Annotated, Any

import typer

from reachtest.commands.arguments import LevelFile
from reachtest.commands.say import say

navmesh = typer.Typer(help="Look at nav-meshes, and build them.", no_args_is_help=True)

_LENGTH = {"min": 1e-6, "max": 10.0}


class Faces(enum.StrEnum):
    """Which faces can be floors."""

    UP = "up"
    ANY = "any"


@navmesh.command()
def build(
    level: LevelFile,
    out: Annotated[Path, typer.Option("--out", "-o", help="File to write: .glb or .obj.")],
    cell: Annotated[
        float | None, typer.Option(**_LENGTH, help="Width of a voxel [m]. [default: radius / 2]")
    ] = None,
    cell_height: Annotated[
        float | None, typer.Option(**_LENGTH, help="Height of a voxel [m]. [default: about cell / 2]")
    ] = None,
    faces: Annotated[Faces | None, typer.Option(help="Faces that can be floors. [default: up]")] = None,
) -> None:
    """Build a nav-mesh from a level's geometry, for its character, and write it to a file.

    What the level file says under navmesh.build counts; a file that it names under navmesh.mesh is not read.
    """
    from reachtest.geometry import triangle_normals
    from reachtest.levels import check_level, load_level
    from reachtest.navmesh.write import write_navmesh

    _check_type(out)
    options = {"cell_m": cell, "cell_height_m": cell_height, "faces": faces.value if faces else None}
    given = {key: value for key, value in options.items() if value is not None}
    loaded = load_level(level, {"navmesh": _section(level, given)})
    built = loaded.navmesh
    for warning in check_level(loaded).warnings:
        typer.echo(f"warning: {warning}", err=True)
    write_navmesh(built, loaded.frame, out)
    area = triangle_normals(built.triangles)[1].sum()
    say(f"{out}: {len(built.faces):,} triangles, {area:,.0f} m2")


def _section(level: Path, given: dict[str, Any]) -> Any:
    """What to put over the level's navmesh section: its own build with `given` over it, or a new one."""
    from reachtest.levels.keys.document import read_yaml
    from reachtest.levels.keys.navmesh import BuildSpec, NavMeshSpec

    section = read_yaml(level).get("navmesh")
    if isinstance(section, dict) and "build" in section:
        return {"build": given}
    spec = BuildSpec.model_validate(given)
    return NavMeshSpec.model_validate({"build": spec})  # no mapping: takes the place of the whole section


def _check_type(out: Path) -> None:
    """Before minutes are spent on what cannot be written."""
    from reachtest.errors import BadInput, Problem
    from reachtest.navmesh.write import TYPES

    if out.suffix.lower() not in TYPES:
        raise BadInput([Problem(str(out), "cannot be written", f"write one of {', '.join(TYPES)}")])
    if not out.resolve().parent.is_dir():
        remedy = "make the folder, or name another"
        raise BadInput([Problem(str(out), f"there is no folder {out.parent}", remedy)])


@navmesh.command()
def info(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A nav-mesh file.")],
    up_axis: Annotated[
        str | None, typer.Option(help="The axis that points up: y or z. [default: the format's, else z]")
    ] = None,
    units: Annotated[
        str | None, typer.Option(help="Of the file: m, cm, mm, in, ft or metres. [default: m]")
    ] = None,
    format: Annotated[
        str, typer.Option(help="Format of the file. [default: what its content says]")
    ] = "auto",
    json_: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Print what is in a nav-mesh file: format, size, islands, agent, areas and links."""
    import json

    from reachtest.levels import read_navmesh_file
    from reachtest.navmesh.facts import facts, table

    found = facts(read_navmesh_file(file, up_axis=up_axis, units=_units(units), format=format))
    say(json.dumps(found, indent=2) if json_ else table(found))


def _units(text: str | None) -> str | float | None:
    """A unit's name, or its length as a number."""
    try:
        return None if text is None else float(text)
    except ValueError:
        return text
