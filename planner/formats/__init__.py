"""Scenes and maps as files: scenes as text or JSON, ROS maps, MovingAI maps.

- ``scene_io.py`` loads and saves files; it recognises a file's kind by its content.
- ``scene_text.py`` defines the scene's text: ``scene_text_reader.py`` reads it with
  ``line_scanner.py``, ``scene_text_writer.py`` writes it.
- ``scene_json.py`` writes the scene as JSON, ``scene_json_reader.py`` reads it.
- ``map_files.py`` reads ROS and MovingAI maps, with pictures from ``pgm.py``; ``grid_maps.py``
  turns their cells into a scene.
- ``map_writer.py`` writes a scene as a ROS map.
- ``mask_files.py`` reads and writes Nav2's masks: keep-out zones and speed limits.
"""
