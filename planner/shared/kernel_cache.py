"""Folder of the compiled kernels, chosen before numba is imported.

numba keeps compiled code beside the source or in the user's cache directory, and raises
``RuntimeError: cannot cache function`` if neither is writable: a system-wide install under a
service user without a home. Then a private directory is chosen here. As it holds code, a directory
that others can write to is never used.
"""

from __future__ import annotations

import os
import stat
import sys
import tempfile
from pathlib import Path


def choose_kernel_cache(package_folder: Path) -> Path | None:
    """Set ``NUMBA_CACHE_DIR`` if numba's own choice would fail; return the folder or None."""
    if os.environ.get("NUMBA_CACHE_DIR") or _is_writable(package_folder):
        return None
    for folder in _candidates():
        if _make_private(folder):
            break
    else:
        folder = Path(tempfile.mkdtemp(prefix="clearway-kernels-"))
    os.environ["NUMBA_CACHE_DIR"] = str(folder)
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = str(folder)
    return folder


def _candidates() -> list[Path]:
    found = []
    if service := os.environ.get("CACHE_DIRECTORY"):
        found.append(Path(service.split(":")[0]) / "kernels")
    if xdg := os.environ.get("XDG_CACHE_HOME"):
        found.append(Path(xdg) / "clearway" / "kernels")
    home = Path(os.path.expanduser("~"))
    if home.is_dir():
        found.append(home / ".cache" / "clearway" / "kernels")
    user = "own" if os.name == "nt" else os.getuid()  # on Windows the folder is the user's
    found.append(Path(tempfile.gettempdir()) / f"clearway-kernels-{user}")
    return found


def _is_writable(folder: Path) -> bool:
    cache = folder / "__pycache__"
    return os.access(cache if cache.is_dir() else folder, os.W_OK)


def _make_private(folder: Path) -> bool:
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        info = folder.lstat()
    except OSError:
        return False
    return stat.S_ISDIR(info.st_mode) and _is_private(info) and os.access(folder, os.W_OK)


def _is_private(info: os.stat_result) -> bool:
    """True if no other user can write; on Windows a user's own folders have no such bits."""
    if os.name == "nt":
        return True
    return info.st_uid == os.getuid() and not info.st_mode & 0o022
