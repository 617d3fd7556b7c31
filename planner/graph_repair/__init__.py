"""The repair of a route graph: every node and edge that is unsafe, moved or led round.

- ``repair.py`` is the interface; it audits, repairs, and audits again.
- ``solid_ground.py`` joins a map with its keep-out zones; ``free_places.py`` finds places for nodes
  on it, ``detours.py`` paths for edges.
- ``fresh_ids.py`` gives ids to the nodes and edges that a detour adds.
"""
