"""Who imports whom, between the folders of a package, from the imports that are written.

Imports inside functions and those for types only count too: a reader follows them all. The
``__init__`` of a package stands above its folders as its public face and is no part of a circle
among them.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Sequence

import networkx as nx

from benchmarks.house.tree import File


def imported(file: File, known: frozenset[str]) -> set[str]:
    """The modules among the known ones that a file imports, the deepest that is meant."""
    found = set()
    for node in ast.walk(file.tree):
        if isinstance(node, ast.Import):
            found |= {deepest(alias.name, known) for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = origin(file, node)
            found |= {deepest(f"{base}.{alias.name}", known) for alias in node.names}
    return found - {"", file.module}


def origin(file: File, node: ast.ImportFrom) -> str:
    """The module after ``from``, with the dots of a relative import counted out."""
    if not node.level:
        return node.module or ""
    parts = file.module.split(".")
    kept = len(parts) - node.level + file.is_init
    return ".".join([*parts[:kept], *([node.module] if node.module else [])])


def deepest(name: str, known: frozenset[str]) -> str:
    """The longest beginning of a dotted name that is a module; empty where none is."""
    while name and name not in known:
        name = name.rpartition(".")[0]
    return name


def module_graph(files: Sequence[File]) -> nx.DiGraph:
    """An arrow from each module to every module that it imports."""
    known = frozenset(file.module for file in files)
    graph = nx.DiGraph()
    graph.add_nodes_from(sorted(known))
    for file in files:
        graph.add_edges_from((file.module, other) for other in sorted(imported(file, known)))
    return graph


def child(module: str, folder: str) -> str:
    """The part of a folder in which a module is, as a dotted name; empty for none."""
    if not module.startswith(f"{folder}."):
        return ""
    return f"{folder}." + module[len(folder) + 1 :].partition(".")[0]


def folder_graph(modules: nx.DiGraph, folder: str) -> nx.DiGraph:
    """The parts of one folder, its modules and sub-folders, with arrows between them."""
    graph = nx.DiGraph()
    for module in modules:
        if part := child(module, folder):
            graph.add_node(part)
    for a, b in modules.edges:
        one, other = child(a, folder), child(b, folder)
        if one and other and one != other:
            graph.add_edge(one, other)
    return graph


def circles(files: Iterable[File]) -> list[str]:
    """A sentence for each group of parts of one folder that import each other in a circle."""
    files = list(files)
    modules = module_graph(files)
    found = []
    for folder in sorted({file.module for file in files if file.is_init}):
        groups = nx.strongly_connected_components(folder_graph(modules, folder))
        for group in sorted(sorted(group) for group in groups):
            if len(group) > 1:
                found.append(f"{folder}: {', '.join(group)} import each other in a circle")
    return found
