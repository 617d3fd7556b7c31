"""The repair of a route graph: every node and edge that is unsafe, moved or led round.

- ``repair`` is the interface; it audits, repairs, and audits again.
- ``solid_ground`` joins a map with its keep-out zones; ``free_places`` finds places for nodes on
  it, ``detours`` paths for edges, with ids of ``fresh_ids``.
"""
