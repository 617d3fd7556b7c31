"""Compiled kernels: ready before a run, and inside a wheel.

- `rehearsal` runs everything that needs kernels once; `plan_together` adds what fleets need.
- `compiling` does so in processes of their own, and reports progress.
- `warm_up` compiles or loads the kernels before the robot may move.
- `compile_ahead` compiles them into the folder that a wheel carries.
"""
