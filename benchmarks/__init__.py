"""What the program is measured by: each command is ``python -m benchmarks.NAME``.

A benchmark of one file stands here; one of several is a folder with ``__main__.py``.

- vision: vision, outlines, markers, watching
- planner: voronoi, roadmap, routes, grid_scenes
- both of them: chain, paper
- firmware_protocol: link, faults, soak
- navigation: daemon, dashboard, recording, sweep, adversary
- the code itself: house; its tests: suite; its runs after a change as before: same_runs

Tables go to ``results``, peers in C++ are in ``native``. A benchmark measures and asserts nothing.
"""
