"""One HTTP POST, as a process of its own: names, certificates and servers may take any time.

`outside_calls.py` runs this file. Standard input has JSON with ``url`` and ``body``, so that no
list of processes shows the address, whose path may be a key. Exits 0 if the server has taken it,
else 1 with the reason on standard error. A redirection is not followed: the configuration names the
address that is called. The standard library alone is used, so that Python starts without the
packages around it.
"""

from __future__ import annotations

import http.client
import json
import sys
from urllib.parse import urlsplit


def post(url: str, body: str) -> str:
    """Post JSON; return the reason why it was not taken, empty if it was.

    Raises ``OSError`` or ``HTTPException`` if there is no answer.
    """
    parts = urlsplit(url)
    is_secure = parts.scheme == "https"
    kind = http.client.HTTPSConnection if is_secure else http.client.HTTPConnection
    line = kind(parts.hostname or "", parts.port)
    target = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
    headers = {"Content-Type": "application/json", "User-Agent": "clearway"}
    line.request("POST", target, body.encode(), headers)
    answer = line.getresponse()
    return "" if 200 <= answer.status < 300 else f"answered {answer.status} {answer.reason}".strip()


def main() -> int:
    """Read what to post, and report."""
    asked = json.load(sys.stdin)
    try:
        reason = post(asked["url"], asked["body"])
    except (OSError, http.client.HTTPException) as error:
        said = error.strerror if isinstance(error, OSError) else None
        reason = said or str(error) or type(error).__name__
    if reason:
        print(reason, file=sys.stderr)
    return 1 if reason else 0


if __name__ == "__main__":
    sys.exit(main())
