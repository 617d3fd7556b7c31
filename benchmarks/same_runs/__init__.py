"""The proof that a change of the code changes no behaviour: ``python -m benchmarks.same_runs``.

In virtual time a run is the same every time. So every shipped configuration is driven with many
seeds and through many troubles, and what crosses the program's borders is hashed: every order to a
link with its arguments and its time, every order that reaches a robot, the path that each robot
really drove, the sentences that people read, and the report.

``cases`` names the runs, ``troubles`` says what goes wrong in them and ``script`` when; ``program``
drives one: nothing else here knows the daemon or the simulated world. ``trace`` notes and hashes,
``kept`` writes a line a run and compares.
"""
