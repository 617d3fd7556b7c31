"""The program runs with what a user gets: nothing that only the developers' tools bring along."""

from __future__ import annotations

import ast
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

TOP = Path(__file__).resolve().parents[2]
PACKAGES = ("clearway", "vision", "planner", "navigation", "firmware_protocol")
SOURCES = sorted(path for package in PACKAGES for path in (TOP / package).rglob("*.py"))
KERNELS = [path for path in SOURCES if path.name.endswith("_kernels.py")]
NEEDS_SCIPY = {"linalg", "dot", "vdot", "matmul"}
"""Attributes of NumPy that numba compiles only where scipy is installed, which no user needs."""


def named(path: Path) -> str:
    return str(path.relative_to(TOP))


@pytest.mark.parametrize("path", KERNELS, ids=named)
def test_a_kernel_compiles_without_scipy(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text())):
        where = f"{named(path)}:{getattr(node, 'lineno', 0)}"
        assert not isinstance(node, ast.MatMult), f"matrix product in {named(path)}"
        if isinstance(node, ast.Attribute):
            assert node.attr not in NEEDS_SCIPY, f"{where}: {node.attr}"


def test_every_import_is_declared_in_the_project_file() -> None:
    project = tomllib.loads((TOP / "pyproject.toml").read_text())["project"]
    extras = project.get("optional-dependencies", {})
    optional = [
        need for extra in ("cluster", "examples", "parquet") for need in extras.get(extra, ())
    ]
    wanted = [*project["dependencies"], *optional]
    declared = {_distribution(requirement) for requirement in wanted}
    provides = packages_distributions()
    for path in SOURCES:
        for name in _imported(ast.parse(path.read_text())):
            owners = {_normal(owner) for owner in provides.get(name, ())}
            owners.discard("clearway")
            assert not owners or owners & declared, f"{named(path)} imports {name}"


def _imported(tree: ast.AST) -> set[str]:
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found.update(alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found.add(node.module.split(".")[0])
    return found


def _distribution(requirement: str) -> str:
    for end, letter in enumerate(requirement):
        if not (letter.isalnum() or letter in "-_."):
            return _normal(requirement[:end])
    return _normal(requirement)


def _normal(name: str) -> str:
    return name.lower().replace("_", "-").replace(".", "-")
