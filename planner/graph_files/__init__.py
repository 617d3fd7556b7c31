"""Route graphs as files: Nav2 GeoJSON, LIF, Open-RMF, GraphML, node-link JSON.

- ``route_graph.py`` defines the graph in memory; ``convert.py`` fits it to another format.
- ``geojson.py``, ``lif.py``, ``rmf.py``, ``graphml.py`` and ``node_link.py`` each read and write
  one format; ``file_place.py`` checks values and names their place in errors.
- ``graph_io.py`` recognises a file by its content and chooses a format by a file's suffix.

A format reads what it knows into the graph's own fields and keeps all the rest in ``fields``, so
that reading, writing and reading again gives an equal graph.
"""

from collections.abc import Mapping
from typing import Final, Literal, TypeAlias

GraphFormat: TypeAlias = Literal["nav2", "lif", "rmf", "graphml", "node-link"]
SUFFIXES: Final[Mapping[str, GraphFormat]] = {
    ".graphml": "graphml",
    ".geojson": "nav2",
    ".json": "node-link",
    ".lif": "lif",
    ".yaml": "rmf",
    ".yml": "rmf",
}
"""Formats by the suffix of a written file; here, so that ``--help`` loads nothing else."""
