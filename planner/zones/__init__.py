"""Zones: where robots may not be, drive slowly, in one direction, along a lane, or not wait.

- ``areas.py`` defines the areas (polygon, circle, band, mask) and their outlines; ``zone.py`` the
  zones.
- ``zone_ground.py`` measures places and paths against one zone's area.
- ``rules.py`` checks a path against the zones, with the sentence for each breach.
- ``way_out.py`` leads a robot out of a keep-out zone; ``lanes.py`` plans over lanes and one-way
  zones.
- ``zoned_roadmap.py`` combines these: a roadmap with zones, which plans like one without.
- ``masks.py`` reads zones from Nav2's masks, and writes them.
- ``ruled_graph.py`` gives an exported graph the zones' directions, speeds and costs.

A zone is no obstacle: clearances are those to the walls, with or without zones.
"""
