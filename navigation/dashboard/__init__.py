"""The dashboard: a page that shows the arena live and takes orders, in its own thread.

- `server`: the port and its thread; `app`: the addresses.
- `admission`: who may connect, look and order, and who holds the arena.
- `hub`: makes messages from the daemon's published state (`shown`); `viewer` sends them to one
  page, by its `attention`.
- `messages`: their contents and forms; `chronicles`: each robot's recent past.
- `orders`: the page's orders, checked and carried out.
- `visits`: operators' other requests: `settings`, and `calibrating` for the camera's lens.
- `kept`: earlier runs and saved places on disk; `replay`: a recording on the same page.
- `metrics`: numbers for Prometheus; `static/`: the page itself.

The control loop replaces `Daemon.state` after each cycle, and the dashboard reads it: no viewer can
make it wait.
"""

from navigation.dashboard.calibrating.bench import Bench
from navigation.dashboard.kept.runs import KeptRuns
from navigation.dashboard.server import Dashboard

__all__ = ["Bench", "Dashboard", "KeptRuns"]
