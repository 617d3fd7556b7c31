"""Calibrating while somebody holds a board before the camera.

- `taking`: the loop from a camera to a session and its displays.
- `session`: takes frames, returns what to show; picks views until they are enough.
- `following`: finds the board in every frame, quickly.
- `board_stillness`: judges if the board is held still.
- `guide`: parts of the picture that still need it, and the next pose to hold it in.
"""
