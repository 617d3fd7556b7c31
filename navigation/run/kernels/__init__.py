"""Compiled kernels: ready before a run, and inside a wheel.

- `rehearsal` runs everything that needs kernels once, on small examples; `plan_together` adds what
  several robots need.
- `compiling` does so in processes of their own, and reports progress.
- `warm_up` compiles or loads the kernels before the robot may move.
- `compile_ahead` compiles them into the folder that a wheel carries.
"""
