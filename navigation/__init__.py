"""Navigation Control: the running program.

The control loop stands on this floor, from `eye` and `pilot` to `serial_link`; `daemon` turns it.
Around it, each in a folder: `config`, `draw`, `recording`, `simulator` and `machine` below;
`dashboard`, `run`, `sweep` and `cli` above.
"""
