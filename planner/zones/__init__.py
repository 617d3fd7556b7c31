"""Zones: where robots may not be, drive slowly, in one direction, along a lane, or not wait.

- ``areas`` defines the areas and their outlines; ``zone`` the zones.
- ``zone_ground`` measures places and paths against one zone's area.
- ``rules`` checks a path against the zones, with the sentence for each breach.
- ``way_out`` leads a robot out of a keep-out zone; ``lanes`` plans over lanes and one-way zones.
- ``zoned_roadmap`` combines these: a roadmap with zones, which plans like one without.
- ``masks`` reads and writes Nav2's masks; ``ruled_graph`` gives an exported graph the zones'
  directions, speeds and costs.

A zone is no obstacle: clearances are those to the walls, with or without zones.
"""
