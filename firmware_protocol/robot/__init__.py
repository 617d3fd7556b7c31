"""The robot's end of the line in Python.

- `clearway`: all that the robot decides and says, in whole numbers. It is copied to MicroPython
  boards as it is, and runs here too.
- `boards`: a program for each board; `package.json` lists the files of `clearway` for `mip`.
- `controller`, `connection`: the same robot in SI units, for the simulator and the drivers.
"""
