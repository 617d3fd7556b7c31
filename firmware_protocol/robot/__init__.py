"""The robot's end of the line in Python.

- `clearway`: all decisions and reports of the robot, in whole numbers. It is copied unchanged to
  MicroPython boards, and runs here too.
- `boards`: a program for each board; `package.json` lists the files of `clearway` for `mip`.
- `controller`, `connection`: the same robot in SI units, for simulator and drivers.
"""
