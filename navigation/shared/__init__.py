"""Small helpers that any part of the running program may use.

- ``outside.py`` reads JSON that comes from outside and makes it safe to repeat.
- ``track.py`` keeps the places a robot has been in a buffer of fixed size.
- ``sealed.py`` puts a checksum line before a text, so that any damage is noticed.
- ``whole_file.py`` writes files that are complete or not there at all.
- ``supervisor.py`` restarts failed parts of the program.
- ``system.py`` refuses what needs Linux on other systems.
"""
