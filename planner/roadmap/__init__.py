"""The roadmap: the part of the diagram that a robot of some radius can drive, and plans on it.

- ``roadmap`` is the interface: ``build_roadmap`` runs the stages, ``Roadmap`` plans.
- ``clip`` cuts the diagram's chains where they pass the radius.
- ``graph`` makes a graph of the wide chains, without spurs; ``curves`` makes lines for pictures.
- ``remarks`` comments on the scene; ``roadmap_export`` writes the graph for other programs.
"""
