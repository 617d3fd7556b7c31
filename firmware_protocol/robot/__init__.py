"""The robot's end of the line in Python.

- `clearway`: all decisions and reports of the robot, in whole numbers; MicroPython boards get it
  unchanged.
- `boards`: a program for each board; `package.json` lists the files of `clearway` for `mip`.
- `controller`, `connection`: the same robot in SI units, for simulator and drivers.
"""
