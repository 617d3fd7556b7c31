"""The computer that the program runs on.

- `doctor` checks it before a run; `camera_findings` and `camera_picture` judge a camera, and
  `camera_section` writes its best section of the configuration.
- `service` makes the systemd unit and the udev rule; `sd_notify` reports to systemd while a run
  lasts.
- `logs` is the log, one line an event.
- `outside_calls` and `post` call other programs and web servers.
- `descriptors` and `child` keep file descriptors in reserve, and end helper processes with the
  program.
- `bundle` packs a fault report into one zip file.
"""
