"""The roadmap: the part of the diagram that a robot of some radius can drive, and plans on it.

- ``roadmap.py`` is the interface: ``build_roadmap`` runs the stages, ``Roadmap`` plans.
- ``clip.py``, with ``clip_kernels.py``, cuts the diagram's chains where they pass the radius.
- ``graph.py`` makes a graph of the wide chains, without spurs; ``curves.py`` makes lines for
  pictures without that graph.
- ``remarks.py`` describes what is remarkable about the scene; ``roadmap_export.py`` writes the
  graph for other programs.
"""
