"""Route graphs as files: Nav2 GeoJSON, LIF, Open-RMF, GraphML, node-link JSON.

- ``route_graph`` defines the graph in memory; ``convert`` fits it to another format.
- ``geojson``, ``lif``, ``rmf``, ``graphml`` and ``node_link`` each read and write one format;
  ``file_place`` checks values.
- ``graph_io`` recognises a file by its content and chooses a format by a file's suffix.

A format keeps all that it does not know in ``fields``, so that reading, writing and reading again
gives an equal graph.
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
"""By the suffix of a written file; here, so that ``--help`` loads nothing else."""
