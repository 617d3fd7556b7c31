"""A standing judge: attacks on the whole system, each judged by where the robot really was.

Real processes over pseudo-terminals, Motion JPEG over HTTP and Unix sockets. In this order:

- `scene` writes the configuration of one run; `processes` starts and ends its processes
- `stage` has what stands in for the world: the man in the middle on the serial line, a network
  camera with faults, a robot that can be carried, crowds at the program's doors
- `rig` puts one run together and drives it to the moment of the attack; `attacks` has them all
- `truth` samples where the robot really is, `bars` judges it, `report` writes the table; `run`
  is one attack from its beginning to its outcome

`python -m benchmarks.adversary --help`.
"""
