"""Small helpers for any part of the running program.

- `outside`: JSON from outside, read and made safe to repeat.
- `track`: the places a robot has been.
- `sealed`: a checksum line before a text; `whole_file`: files written whole or not at all.
- `map_pictures`: pictures of maps and masks that OpenCV decodes.
- `supervisor`: restarts failed parts of the program.
- `system`: refuses what needs Linux elsewhere.
- `garbage`: keeps Python's garbage collector away from what is imported.
"""
