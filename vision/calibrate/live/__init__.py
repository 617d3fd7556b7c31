"""Calibrating while somebody holds a board before the camera.

- `following`: the board in every frame, quickly.
- `stillness`: whether it stands still.
- `guide`: which parts of the picture still want it, and how to hold it next.
- `session`: frames in, what to show out; takes views by itself and knows when they are enough.
- `taking`: the loop from a camera to a session and to whoever shows it.
"""
