"""The stages never import each other: whoever reads one needs to know the records, and nothing else."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import reachtest

PACKAGE = Path(reachtest.__file__).parent
STAGES = ("levels", "world", "explore", "findings", "confirm", "logs", "report")
WIRING = ("pipeline", "cli", "commands", "bench", "replaying")  # these may import every stage
TOOLBOX = "reachtest.navmesh"  # what several stages need to know of nav-meshes
MODULES = {
    ".".join(("reachtest", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__"): path
    for path in sorted(PACKAGE.rglob("*.py"))
}
SHARED = {
    "reachtest",
    "reachtest.records",
    "reachtest.interfaces",
    "reachtest.errors",
    "reachtest.files",
    "reachtest.columns",
    "reachtest.walking",
    "reachtest.connected",
    "reachtest.geometry",
    "reachtest.offlimits",
    "reachtest.surface",
}
SHARED |= {module for module in MODULES if module.startswith((TOOLBOX, "reachtest.records"))}
COMMAND_LINE = [module for module in MODULES if module.startswith(("reachtest.cli", "reachtest.commands"))]


def imports(module: str) -> set[str]:
    """Modules of the package that `module` imports, wherever in the file the import stands."""
    found = set()
    for node in ast.walk(ast.parse(MODULES[module].read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module} imports relatively: this test could not follow it"
            # `from reachtest import levels` names a module, `from reachtest.levels import load` a name.
            named = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {name for name in named if name in MODULES} or {str(node.module)}
    return {name for name in found if name.split(".")[0] == "reachtest"}


def stage(module: str) -> str | None:
    parts = module.split(".")
    return parts[1] if len(parts) > 1 and parts[1] in STAGES else None


def wires(module: str) -> bool:
    return module.split(".")[1:2] != [] and module.split(".")[1] in WIRING


def test_every_stage_is_looked_at() -> None:
    assert {stage(module) for module in MODULES} - {None} == set(STAGES)
    assert "reachtest.levels" in imports("reachtest.pipeline")


@pytest.mark.parametrize("module", [module for module in MODULES if stage(module)])
def test_stage_imports_itself_and_what_is_shared(module: str) -> None:
    foreign = {name for name in imports(module) if name not in SHARED and stage(name) != stage(module)}
    assert not foreign


@pytest.mark.parametrize("module", [m for m in MODULES if not stage(m) and not wires(m)])
def test_only_the_wiring_imports_stages(module: str) -> None:
    assert not {name for name in imports(module) if stage(name)}


@pytest.mark.parametrize("module", sorted(SHARED))
def test_what_is_shared_needs_nothing_but_what_is_shared(module: str) -> None:
    assert imports(module) <= SHARED


@pytest.mark.parametrize("module", COMMAND_LINE)
def test_heavy_packages_are_not_imported_with_the_command_line(module: str) -> None:
    tree = ast.parse(MODULES[module].read_text(encoding="utf-8"))
    at_once = {
        name.split(".")[0]
        for node in tree.body
        if isinstance(node, ast.Import | ast.ImportFrom)
        for name in (
            [alias.name for alias in node.names] if isinstance(node, ast.Import) else [str(node.module)]
        )
    }
    assert not at_once & {"numpy", "scipy", "trimesh", "mujoco", "rtree", "mcap", "pydantic"}
