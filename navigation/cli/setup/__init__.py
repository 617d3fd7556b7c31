"""Commands that set up a machine and an arena.

- `sample` and `init_config` write a sample and a first configuration (`starter_values`); `schema`
  describes the keys.
- `devices` lists ports and cameras; `camera` judges a camera by `camera_watch`.
- `marker` prints markers and boards; `calibrate` calibrates a camera, `reanchor` places a moved one
  again.
- `check` checks a configuration, `doctor` the machine.
- `install_service` and `completion` fit it to the system and the shell.
"""
