"""The control loop: see, plan, decide and send, once a cycle, for one robot or several.

- `daemon` runs a cycle: `seeing/` gives poses and scene, `planning` a path, `traffic/` says how
  far each robot may drive along it, `robot` decides with its pilot, and `robot_orders` puts the
  decision on the link.
- `people` and `stopping` take people's orders, `zones_in_force` their zones.
- `planner_news` and `punctuality` report the planner's findings, and late threads.
- `run_state`, `reports` and `recorder` pass the state on after each cycle.
- `parts` names what the loop needs of its world; `stages` and `firmware_settings` turn a
  configuration into settings.
"""
