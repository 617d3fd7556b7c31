"""The dashboard: a page that shows the arena live and takes orders, in a thread of its own.

- `server`: the port, the thread, its life; `app`: what is at which address.
- `connections`, `places`: who is connected, and who makes room where there are too many.
- `access`: who may; `own_token`: what one needs where no token is configured; `seat`: who holds the
  arena.
- `hub`: from the daemon's published state to what viewers are told; `viewer`: one of them, with its
  `attention`: what it has got and could take.
- `shown`: the daemon as it is looked at; `chronicles`: what happened lately, of each robot.
- `state_message`, `geometry`, `picture`, `packed`, `rings`: what is told, and in which form.
- `visits`: what operators read and change beside orders: `settings`, and `calibrating`, where the
  camera's lens is calibrated.
- `kept`: what is on disk, earlier runs with their files.
- `replay`: a recording on the same page.
- `metrics`, `palette`, `static/`: numbers for Prometheus, colours shared with the pictures, the
  page itself (ES modules, no build step).

The control loop knows nothing of all this: it replaces `Daemon.state` after each cycle, and the
dashboard looks. Nobody who watches can make it wait.
"""

from navigation.dashboard.calibrating.bench import Bench
from navigation.dashboard.kept.runs import KeptRuns
from navigation.dashboard.server import Dashboard

__all__ = ["Bench", "Dashboard", "KeptRuns"]
