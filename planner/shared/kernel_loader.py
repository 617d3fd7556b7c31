"""Load a compiled kernel without making numba ready to compile.

Before numba looks for a kept kernel it imports all that compiling may need; and with the machine
code it parses the bitcode, which only a kernel compiled later wants. Together that was a third of
the time of a command whose kernels are all compiled. Here both wait until something is compiled.

Extends the cache that numba gives every function, for our kernels only, and leaves it as it is
where a version of numba lacks what is used here.
"""

# mypy: allow-untyped-calls

from __future__ import annotations

import pickle
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

from numba.core import caching, codegen, environment
from numba.core.runtime.nrt import rtsys

from planner.shared.kernel_compiler import PART, KernelLibrary, is_part

NEEDED = (
    (caching.FunctionCache, ("_index_key", "_load_overload")),
    (codegen.CPUCodeLibrary, ("_unserialize", "_set_compiled_object", "_finalize_final_module")),
    (codegen.CPUCodegen, ("create_library", "unserialize_library")),
    (codegen.JitEngine, ("_load_defined_symbols", "is_symbol_defined")),
    (caching.IndexDataCacheFile, ("_load_index", "_data_path")),
    (environment, ("Environment", "_rebuild_env", "lookup_environment")),
    (type(rtsys), ("initialize",)),
)
"""Numba's own that is used here; each has been there since version 0.60 at least."""


class LoadedLibrary(codegen.JITCodeLibrary):
    """Kept machine code, whose bitcode is parsed when a kernel that calls it is compiled."""

    _bitcode = b""
    _parsed: Any = None

    @classmethod
    def _unserialize(cls, own_codegen: Any, state: Any) -> Any:
        """As numba does, but the bitcode stays as it is."""
        name, kind, data = state
        if kind == PART:
            return KernelLibrary.of_part(own_codegen, name, data)
        if kind != "object":
            return super()._unserialize(own_codegen, state)
        machine_code, bitcode = data
        library = cls(own_codegen, name)
        library.enable_object_caching()
        library._set_compiled_object(machine_code)
        library._bitcode = bitcode
        library._finalize_final_module()
        return library

    @property
    def _shared_module(self) -> Any:
        """What numba links into a kernel that calls this one."""
        if self._parsed is None and self._bitcode:
            self._parsed = codegen.ll.parse_bitcode(self._bitcode)  # type: ignore[attr-defined]
            self._bitcode = b""
            self._codegen._engine._load_defined_symbols(self._parsed)
        return self._parsed

    @_shared_module.setter
    def _shared_module(self, module: Any) -> None:
        self._parsed = module


def load_lightly(locator: type) -> bool:
    """From now on, kernels that a locator of this class finds are loaded as this module says.

    False where this version of numba lacks what that takes.
    """
    if not all(hasattr(owner, name) for owner, names in NEEDED for name in names):
        return False
    numbas = caching.FunctionCache.load_overload

    def load_overload(self: Any, signature: Any, target: Any) -> Any:
        if not (self._enabled and isinstance(self._impl.locator, locator)):
            return numbas(self, signature, target)
        rtsys.initialize(target)
        found = _read(self._cache_file, self._index_key(signature, target.codegen()))
        if found is None or (found[0][1] == PART and not is_part()):
            target.refresh()  # ready to compile
            return None
        if found[0][1] == PART:
            return _part(self, target, found)
        function = found[1]
        target.codegen()._engine._defined_symbols.add(function.llvm_cpython_wrapper_name)
        with _light_libraries(target.codegen()):
            return self._impl.rebuild(target, found)

    setattr(caching.FunctionCache, "load_overload", load_overload)  # noqa: B010 - for mypy it is a method
    return True


def _part(cache: Any, target: Any, found: Any) -> Any:
    """A part that another kernel is built on; what it refers to is set once that has its code."""
    *kept, environments = found
    with _light_libraries(target.codegen()):
        rebuilt = cache._impl.rebuild(target, (*kept, ()))
    return rebuilt._replace(referenced_envs=environments)


def _read(file: Any, key: Any) -> Any:
    """What is kept of a kernel for these types, or None; as numba's own ``load`` does."""
    name = file._load_index().get(key)
    if name is None:
        return None
    try:
        kept = Path(file._data_path(name)).read_bytes()
    except OSError:  # removed, while the index still names it
        return None
    return _Unpickler(BytesIO(kept)).load()


class _Unpickler(pickle.Unpickler):
    """Reads a kept kernel without importing the modules of numba that its code was made from."""

    def find_class(self, module: str, name: str) -> Any:
        """As ever, but for the environments."""
        if (module, name) == ("numba.core.environment", "_rebuild_env"):
            return _environment
        return super().find_class(module, name)


def _environment(module: str, constants: Any, name: str) -> Any:
    """What compiled code refers to at run time: its constants.

    The globals are for code that runs Python's objects, of which no kernel has any: those of a
    module of numba that is not loaded are left out.
    """
    known = environment.lookup_environment(name)
    if known is not None:
        # perhaps a part's, compiled by another process under the same number: its entry has more
        known.consts.extend(constants[len(known.consts) :])
    if known is not None or not module.startswith("numba.") or module in sys.modules:
        return known or environment._rebuild_env(module, constants, name)
    made = environment.Environment({"__name__": module})
    made.consts[:] = constants
    made.env_name = name
    environment.Environment._memo[name] = made
    return made


@contextmanager
def _light_libraries(own_codegen: Any) -> Iterator[None]:
    """Numba holds its compiler's lock meanwhile."""
    usual = own_codegen._library_class
    own_codegen._library_class = LoadedLibrary
    try:
        yield
    finally:
        own_codegen._library_class = usual
