"""Pictures and a map to try things with.

- ``sample.py`` gives their paths by name.
- ``arena.png``, ``maze.png`` and ``photograph.jpg`` are pictures of dark obstacles on a light
  floor.
- ``rooms.yaml`` is a ROS map with the picture ``rooms.pgm``.

Draw them again with ``python -m benchmarks.figures.samples``.
"""
