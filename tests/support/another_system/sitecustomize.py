"""Windows as our packages see it: begun by Python itself, in this process and in its children.

With this folder on PYTHONPATH, an import from one of our packages finds no module that only Unix
has, and modules of both systems without what Windows lacks. Other packages, which have their own
code for each system, see the real ones.

Lists: "Availability: Unix" and "not Windows" in the documentation of Python 3.11's library.
"""

from __future__ import annotations

import builtins
import importlib
import re
import sys
import warnings
from types import ModuleType
from typing import Any

OURS = frozenset({"clearway", "vision", "planner", "navigation", "firmware_protocol"})
UNIX = r"crypt|curses|fcntl|grp|nis|posix|pty|pwd|readline|resource|spwd|syslog|termios|tty"
LACKS = {
    "os": r"(get|set)(res)?(e?[ug]id|groups|sid|pgid|priority|loadavg)s?|getpgrp|getlogin_r"
    r"|O_(CLOEXEC|NONBLOCK|NOFOLLOW|DIRECTORY|SYNC|DSYNC|NOCTTY|PATH|TMPFILE|DIRECT|NOATIME)"
    r"|openpty|forkpty|fork|ttyname|ctermid|uname|statvfs|fstatvfs|p?(read|write)v|pread|pwrite"
    r"|fchmod|l?chown|fchown|fchdir|chroot|mkfifo|mknod|sched_\w+|SCHED_\w+|sysconf\w*|confstr\w*"
    r"|memfd_create|eventfd\w*|(set|get)_blocking|nice|killpg|wait[34]?|waitid|W[A-Z]+|pipe2|sync"
    r"|fdatasync|posix_\w+|sendfile|splice|copy_file_range|register_at_fork|environb|getenvb",
    "signal": r"SIG(?!ABRT|FPE|ILL|INT|SEGV|TERM|NALS|_DFL|_IGN)[A-Z0-9]+|alarm|setitimer|pause"
    r"|pthread_\w+|sig(wait|pending)\w*|siginterrupt",
    "socket": r"AF_(UNIX|NETLINK|PACKET|ALG|VSOCK)|SO_(PEERCRED|REUSEPORT|PASSCRED)|SCM_\w+"
    r"|SOCK_(CLOEXEC|NONBLOCK)|MSG_(DONTWAIT|NOSIGNAL)|(send|recv)_fds",
    "select": r"e?poll|EPOLL\w*|POLL\w*|PIPE_BUF",
    "time": r"clock_(get|set)\w+|CLOCK_\w+|pthread_\w+|tzset",
}
INSTEAD = {"sys": {"platform": "win32"}, "os": {"name": "nt"}}


class _WithoutUnix:
    """A module of the library as another system has it; everything else is the real one's."""

    def __init__(self, real: ModuleType) -> None:
        vars(self)["_real"] = real

    def __getattr__(self, name: str) -> Any:
        of = self._real.__name__
        if name in INSTEAD.get(of, {}):
            return INSTEAD[of][name]
        if re.fullmatch(LACKS.get(of, ""), name):
            raise AttributeError(f"module '{of}' has no attribute '{name}' here")
        return getattr(self._real, name)

    def __setattr__(self, name: str, value: object) -> None:
        setattr(self._real, name, value)


_real_import = builtins.__import__
_proxies = {name: _WithoutUnix(importlib.import_module(name)) for name in LACKS | INSTEAD}


def _import(
    name: str, scope: Any = None, locals_: Any = None, fromlist: Any = (), level: int = 0
) -> Any:
    importer = str((scope or {}).get("__name__", "")).partition(".")[0]
    if level or importer not in OURS:
        return _real_import(name, scope, locals_, fromlist, level)
    top = name.partition(".")[0]
    if re.fullmatch(UNIX, top):
        raise ModuleNotFoundError(f"No module named '{name}'", name=name)
    found = _real_import(name, scope, locals_, fromlist, level)
    return _proxies.get(name if fromlist else top, found)


builtins.__import__ = _import

if sys.flags.warn_default_encoding:  # on Windows it is not UTF-8
    for package in OURS:
        warnings.filterwarnings("error", category=EncodingWarning, module=rf"{package}\b")
