"""Scenes and maps as files: scenes as text or JSON, ROS maps, MovingAI maps.

- ``scene_io`` loads and saves files of any kind.
- ``scene_text`` defines the scene's text: ``scene_text_reader`` reads it with ``line_scanner``,
  ``scene_text_writer`` writes it.
- ``scene_json`` writes the scene as JSON, ``scene_json_reader`` reads it.
- ``map_files`` reads ROS and MovingAI maps, with pictures from ``pgm``; ``grid_maps`` turns their
  cells into a scene; ``map_writer`` writes a scene as a ROS map.
- ``mask_files`` reads and writes Nav2's masks: keep-out zones and speed limits.
"""
