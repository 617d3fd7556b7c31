"""The host's end of the link: sessions, the robot's clock, uploads, orders.

- `connection` takes bytes and time, and gives `events`; `state` is the table of its states.
- `sessions` numbers sessions and notices other hosts; `robot_clock` asks for the robot's.
- `wanted_mission` holds the mission, `upload` sends its waypoints, `commands` the orders.
- `freshest` keeps the newest lease and pose.
- `outgoing` picks the next frame from all of these; `counters` counts.
- `line`: the line's pace, clock, send window and diagnosis.
"""
