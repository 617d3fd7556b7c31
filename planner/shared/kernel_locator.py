"""Locator by which numba finds this distribution's compiled kernels, and checks that they fit.

- A wheel may contain kernels compiled ahead, one folder per processor
  (``planner/compiled/<processor>/``). On first use they are copied to numba's cache; kernels that
  they lack are compiled as usual.
- A kernel fits if its source, all our sources that it imports, and the versions of numba and LLVM
  are unchanged (``source_stamp``). Numba itself only checks one file.

Numba finds the locator by its own setting, ``NUMBA_CACHE_LOCATOR_CLASSES``.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import tempfile
from collections.abc import Callable
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numba

from planner.shared.processor import choose_processor
from planner.shared.source_stamp import stamp_of

PACKAGES = ("planner", "vision")
"""The packages that have kernels, beside each other in one folder."""
ROOT = Path(__file__).parents[2]
SHIPPED = Path(__file__).parents[1] / "compiled"
"""Kernels compiled ahead: ``<processor>/<package>/<module>/*.nbi, *.nbc``."""
STAMP_CHARS = 12
LABEL = "label.txt"
"""Beside shipped kernels: the versions that they were made by, and a digest of their sources."""
CONFIG: Any = numba.config
VERSIONS = f"numba {numba.__version__}, llvmlite {version('llvmlite')}"
USUAL_LOCATORS = (
    "UserProvidedCacheLocator",
    "InTreeCacheLocator",
    "UserWideCacheLocator",
    "IPythonCacheLocator",
    "ZipCacheLocator",
)
"""The locators that numba asks by default, in its order."""


class KernelLocator:
    """Cache of one of our kernels: its folder, and the stamp of all that it depends on.

    Has the methods that numba expects of a locator.
    """

    def __init__(self, py_func: Callable[..., Any], py_file: str) -> None:
        self._py_file = py_file
        self._stem = f"{Path(py_file).stem}.{py_func.__qualname__}-"
        self._line = py_func.__code__.co_firstlineno

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> KernelLocator | None:
        """Locator of one of our functions if its cache is writable; otherwise None."""
        if not _is_kept(py_file, CONFIG.CACHE_DIR):
            return None
        return cls(py_func, py_file)

    def ensure_cache_path(self) -> None:
        """Make the cache's folder and clear it of this kernel's earlier versions.

        Called before a kernel is kept. Raises OSError if the folder is not writable.
        """
        folder = cache_folder(Path(self._py_file).parent)
        _make_writable(folder)
        for file in folder.glob(f"{self._stem}*.nb[ci]"):
            if f"{self._version()}." not in file.name:
                file.unlink(missing_ok=True)

    def get_cache_path(self) -> str:
        """Return the folder of this kernel's cache."""
        return str(cache_folder(Path(self._py_file).parent))

    def get_source_stamp(self) -> str:
        """Return the kernel's stamp."""
        return kernel_stamp(Path(self._py_file))

    def get_disambiguator(self) -> str:
        """Distinguish kernels of one name in one file, and the versions of one kernel.

        An index names its kernel's classes. Numba cannot read the index of an earlier version of
        the source if one of them is gone, so each version has an index of its own.
        """
        return f"{self._line}{self._version()}"

    def _version(self) -> str:
        return f"v{self.get_source_stamp()[:STAMP_CHARS]}"


@cache
def _is_kept(py_file: str, _cache_folder: str) -> bool:
    """True if a file is ours and its kernels can be kept; looked up once for all its kernels."""
    own = any(Path(py_file).is_relative_to(ROOT / package) for package in PACKAGES)
    if not own or not os.path.exists(py_file):
        return False
    try:
        _make_writable(cache_folder(Path(py_file).parent))
    except OSError:  # numba's own locators try more places
        return False
    return True


def _make_writable(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    tempfile.TemporaryFile(dir=folder).close()


@cache
def kernel_stamp(source: Path) -> str:
    """Stamp of everything that a source file's kernels depend on, except this folder."""
    return stamp_of(source, PACKAGES, VERSIONS, apart=Path(__file__).parent)


def cache_folder(source_folder: Path) -> Path:
    """Folder for the kernels of a source folder: beside it, or below ``NUMBA_CACHE_DIR``."""
    if not CONFIG.CACHE_DIR:
        return source_folder / "__pycache__"
    # clones of this project keep theirs apart
    mine = f"{ROOT.name}_{hashlib.sha1(str(ROOT).encode()).hexdigest()[:8]}"
    return Path(CONFIG.CACHE_DIR) / mine / source_folder.relative_to(ROOT)


def prepare_kernels() -> None:
    """Set numba up; called once, before the first kernel is defined."""
    # During a compilation, numba (0.60 to 0.68 at least) remembers failed inferences, and sometimes
    # wrongly: the fourth number of a tuple, deep in the fit of outlines, then has no type, and the
    # kernel is refused.
    CONFIG.reload_config()  # takes the present environment, which numba would take later
    CONFIG.DISABLE_TYPEINFER_FAIL_CACHE = 1
    processor = choose_processor(os.environ)
    own = f"{KernelLocator.__module__}.{KernelLocator.__qualname__}"
    usual = CONFIG.CACHE_LOCATOR_CLASSES or ",".join(USUAL_LOCATORS)
    if own not in usual.split(","):
        CONFIG.CACHE_LOCATOR_CLASSES = f"{own},{usual}"
    if processor is not None:
        with contextlib.suppress(OSError):  # nothing is writable there: numba tries more places
            unpack_shipped(SHIPPED / processor)


def unpack_shipped(shipped: Path) -> int:
    """Copy kernels compiled ahead to where numba looks for them; return the number of files.

    Done once for each set of shipped kernels and each cache, and not at all if other versions of
    numba or LLVM made them. Raises OSError if the cache is not writable.
    """
    label = shipped / LABEL
    if not label.exists():
        return 0
    wanted = label.read_text(encoding="ascii")
    done = cache_folder(ROOT / PACKAGES[0]) / f"{shipped.name}-{LABEL}"
    if not wanted.startswith(f"{VERSIONS}\n") or (done.exists() and done.read_text() == wanted):
        return 0
    copied = 0
    # each kernel's index last, after the files that it names
    for part in sorted(shipped.rglob("*.nb[ci]")):
        folder = cache_folder(ROOT / part.parent.relative_to(shipped))
        folder.mkdir(parents=True, exist_ok=True)
        _put(part.read_bytes(), folder / part.name)
        copied += 1
    _put(wanted.encode(), done)
    return copied


def write_label(shipped: Path) -> None:
    """Write which versions made a folder of compiled kernels, and from which sources."""
    digest = hashlib.sha256()
    for source in sorted(file for one in PACKAGES for file in (ROOT / one).rglob("*.py")):
        digest.update(source.read_bytes())
    (shipped / LABEL).write_text(f"{VERSIONS}\n{digest.hexdigest()}\n", encoding="ascii")


def is_compiled(kernel: Any) -> bool:
    """True if a kernel's code for this processor and these versions is cached."""
    # the index has no public reader: numba opens it only to load or to compile
    codegen = kernel.targetctx.codegen()
    kept = kernel._cache._cache_file._load_index()
    return any(key[1] == codegen.magic_tuple() for key in kept)


def loaded_files(kernel: Any) -> list[Path]:
    """Files of a kernel's compiled code that this process has loaded."""
    # as in `is_compiled`: which file belongs to which types is in the index alone
    file = kernel._cache._cache_file
    magic = kernel.targetctx.codegen().magic_tuple()
    loaded = kernel.stats.cache_hits
    return [
        Path(file._cache_path) / name
        for key, name in file._load_index().items()
        if key[0] in loaded and key[1] == magic
    ]


def _put(content: bytes, file: Path) -> None:
    """Write a file atomically, even if two processes do so at the same time."""
    new = file.with_name(f"{file.name}.{os.getpid()}.new")
    new.write_bytes(content)
    os.replace(new, file)
