"""The serial line to a robot.

- `serial_port` opens the port, or says in one sentence why it cannot; `port_faults` are the errors
  of one that breaks while it is open.
- `robot_link` has the orders to a robot; `serial_link` carries them out in a thread that owns the
  port, around the sans-IO `HostConnection`.
- `link_snapshot` is the state of line and robot at one moment.
- `drivers/` serves robots that speak another maker's protocol.
"""
