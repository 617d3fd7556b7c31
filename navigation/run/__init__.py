"""One run from its beginning to its report, in real or in virtual time.

- `runner` leads it: kernels warmed up (`kernels/`), the world opened, the mission driven, the end.
- `world` connects it to cameras and ports (`devices/`), or to the `simulation`.
- `virtual_run` and `virtual_world` do the same without threads or waiting; `without_pictures/`
  leaves out the drawing.
- `journals` opens what the run before has left; `give_missions` hands out the configured missions;
  `taking_orders` opens the control socket; `reload` and `anchoring` take a new configuration or
  camera place during the run.
- `attendance`, `progress`, `trouble_lines` and `notifications` report each cycle; `run_report` and
  `run_folder` are what remains.
- `replay` runs vision and planner again on a recording.
"""
