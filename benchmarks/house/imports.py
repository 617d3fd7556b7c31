"""Who imports whom, between the folders of a package, from the imports that are written.

Imports inside functions and those for types only count too: a reader follows them all.
"""

from __future__ import annotations

from collections.abc import Sequence

import grimp
import networkx as nx


def module_graph(packages: Sequence[str]) -> nx.DiGraph:
    """An arrow from each module of some packages to every module that it imports."""
    known = grimp.build_graph(*packages, cache_dir=None)
    graph = nx.DiGraph()
    graph.add_nodes_from(sorted(known.modules))
    for module in sorted(known.modules):
        imported = sorted(known.find_modules_directly_imported_by(module))
        graph.add_edges_from((module, other) for other in imported)
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
