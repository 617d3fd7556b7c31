"""Decisions about one robot's mission: sans-IO, with the time passed in.

- `cycle` defines a control cycle's facts and orders; `facts` derives what safety is judged by.
- `watch` has the safety rules; `trust`, `proving`, `stillness` and `traffic` supply evidence.
- `pilot` decides, and `plan_requests` asks for plans; `mission` is the table of states; `progress`
  and `arrival` follow the mission.
- `running_plan`, `late_pictures` and `targets` make the plan's waypoints for the wire.
"""
