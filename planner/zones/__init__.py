"""Zones: where robots may not be, drive slowly, in one direction, along a lane, or not wait.

- ``areas`` defines the areas and their outlines; ``zone`` the zones.
- ``zone_ground`` measures places and paths against a zone; ``rules`` checks a path.
- ``way_out`` leads a robot out of a keep-out zone; ``lanes`` plans over lanes and one-way zones.
- ``zoned_roadmap`` combines these into a roadmap with zones.
- ``masks`` reads and writes Nav2's masks; ``ruled_graph`` applies zones to an exported graph.

A zone is no obstacle: clearances are those to the walls, with or without zones.
"""
