"""Route graphs in and out: the format is recognised by content, and chosen by a file's suffix."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path

from planner.formats.map_files import read_text
from planner.graph_files import SUFFIXES, GraphFormat
from planner.graph_files.convert import converted
from planner.graph_files.file_place import parse_json
from planner.graph_files.geojson import read_geojson, write_geojson
from planner.graph_files.graphml import read_graphml, write_graphml
from planner.graph_files.lif import read_lif, write_lif
from planner.graph_files.node_link import read_node_link, write_node_link
from planner.graph_files.rmf import read_rmf, write_rmf
from planner.graph_files.route_graph import ExchangeError, RouteGraph
from planner.scene import SceneError

READERS: Mapping[GraphFormat, Callable[[str, str], RouteGraph]] = {
    "nav2": read_geojson,
    "lif": read_lif,
    "rmf": read_rmf,
    "graphml": read_graphml,
    "node-link": read_node_link,
}
WRITERS: Mapping[GraphFormat, Callable[[RouteGraph], str]] = {
    "nav2": write_geojson,
    "lif": write_lif,
    "rmf": write_rmf,
    "graphml": write_graphml,
    "node-link": write_node_link,
}


def load_graph(path: str | os.PathLike[str]) -> RouteGraph:
    """Load a route graph: Nav2 GeoJSON, LIF, Open-RMF YAML, GraphML or node-link JSON.

    The content decides, not the suffix. Raises :class:`ExchangeError` with the file and the place.
    """
    try:
        return read_graph(read_text(Path(path)), os.fspath(path))
    except SceneError as error:  # the file cannot be read, or is no text
        raise ExchangeError(str(error)) from None


def read_graph(text: str, name: str) -> RouteGraph:
    """Parse a route graph of any format; errors name the file ``name``."""
    return READERS[_format(text, name)](text, name)


def _format(text: str, name: str) -> GraphFormat:
    begin = text.lstrip()[:1]
    if not begin:
        raise ExchangeError(f"{name}: is empty: must hold a route graph")
    if begin == "<":
        return "graphml"
    if begin != "{":
        return "rmf"
    document = parse_json(text, name)
    known: dict[str, GraphFormat] = {"features": "nav2", "layouts": "lif", "nodes": "node-link"}
    for key, form in known.items():
        if key in document:
            return form
    if "levels" in document:  # JSON is YAML
        return "rmf"
    raise ExchangeError(
        f"{name}: no route graph: must have features (Nav2), layouts (LIF), levels (Open-RMF)"
        " or nodes (node-link)"
    )


def graph_text(graph: RouteGraph, form: GraphFormat) -> str:
    """Write a graph in a format, see :mod:`planner.graph_files.convert`."""
    return WRITERS[form](converted(graph, form))


def format_of(path: str | os.PathLike[str]) -> GraphFormat:
    """Format of a file to write; :class:`ExchangeError` for another suffix."""
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise ExchangeError(f"suffix '{suffix}': must be one of {', '.join(SUFFIXES)}")
    return SUFFIXES[suffix]


def save_graph(
    graph: RouteGraph, path: str | os.PathLike[str], form: GraphFormat | None = None
) -> None:
    """Write a graph in a format, by default that of the suffix.

    Raises :class:`ExchangeError` for another suffix, or a file that cannot be written.
    """
    text = graph_text(graph, format_of(path) if form is None else form)
    try:
        Path(path).write_text(text, encoding="utf-8")
    except OSError as error:
        raise ExchangeError(f"{os.fspath(path)}: {error.strerror or error}") from None
