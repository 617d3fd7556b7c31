"""Decisions about one robot's mission: sans-IO, with the time passed in.

- `cycle` defines a control cycle's facts and orders, and `facts` derives from camera and link what
  safety is judged by.
- `watch` has the safety rules, each with its sentence; `trust`, `proving`, `stillness` and
  `traffic` supply their evidence.
- `pilot` decides with them; `mission` is the table of states, `progress` and `arrival` judge how
  far the mission is.
- `running_plan`, `slowing` and `targets` make the waypoints for the wire from the plan.
"""
