"""Commands that drive, or talk to programs that do.

- `run` runs the daemon on a configuration; `orders` and `zones` send it orders.
- `demo` is a simulated run without any file; `robot` is a simulated robot on a port.
- `dashboard` shows a recording on the page, `replay` repeats vision and planning on one.
- `sweep` repeats a simulated run with other seeds and errors.
"""
