"""The wire: framing, messages and their numbers, independent of both ends.

- `framing` turns bytes into frames and back; `crc` is each frame's check.
- `messages` reads a frame's payload: `host_messages` or `robot_messages`, many a `plain_message`.
- `vocabulary` has the numbers for types, states, reasons, results and flags.
- `values` scales SI units to the integers of the wire and checks their ranges.
- `mission` holds waypoints with their fingerprints; `drive_settings` describes a robot.
- `errors`: ours (``LocalError``) or the wire's (``RemoteError``).
"""
