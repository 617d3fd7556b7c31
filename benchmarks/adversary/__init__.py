"""A standing judge: attacks on the whole system, each judged by where the robot really was.

Real processes over pseudo-terminals, Motion JPEG over HTTP and Unix sockets. In this order:

- `scene` writes the configuration of one run; `processes` starts and ends its processes
- `line` is the man in the middle on the serial line, `camera_server` a network camera with
  faults, `handled_robot` a robot that can be carried and held
- `rig` puts one run together and drives it to the moment of the attack
- `*_attacks` are the attacks, listed by `attacks`
- `truth` samples where the robot really is, `bars` judges it, `report` writes the table

`python -m benchmarks.adversary --help`.
"""
