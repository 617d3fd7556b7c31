"""Compile a kernel that another one calls as a part of it: optimised once, where it ends up.

Numba makes machine code of every kernel, and links what it has optimised into each that calls it,
where it is optimised again: the innermost of ten kernels ten times. And it finds out for every
``a + b`` once more which of some twenty implementations can add. Together these were two fifths of
the time that all kernels take to compile. Here

- a kernel that is compiled because another one calls it is a part: it has no machine code and no
  entry for Python, and is linked as it was written down. If Python calls it later, it is compiled
  as a whole then. What a whole is made of does not depend on which kernels were compiled before;
- the implementation that could take some types is asked first when they come up again;
- two sets of options that were set alike are equal, without a look at those that were not.

Extends numba's compiler while it compiles a kernel of ours, and leaves it as it is for those of
others, and where a version of numba lacks what is used here.
"""

# mypy: allow-untyped-calls

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import caching, codegen, cpu, dispatcher, environment, lowering, sigutils
from numba.core.compiler_lock import global_compiler_lock
from numba.core.errors import NumbaError
from numba.core.target_extension import get_local_target
from numba.core.targetconfig import TargetConfig
from numba.core.types import functions
from numba.core.utils import order_by_target_specificity

NEEDED = (
    (dispatcher.Dispatcher, ("compile", "add_overload")),
    (caching, ("NullCache",)),
    (caching.CacheImpl, ("locator",)),
    (codegen, ("ll",)),
    (codegen.JITCodeLibrary, ("_optimize_final_module", "_finalize_final_module")),
    (codegen.JITCPUCodegen, ("_library_class", "set_env")),
    (cpu.CPUContext, ("get_executable",)),
    (environment, ("lookup_environment",)),
    (functions, ("_unlit_non_poison",)),
    (functions.BaseFunction, ("get_call_type",)),
    (lowering.Lower, ("create_cpython_wrapper",)),
    (TargetConfig, ("__eq__", "__hash__", "values")),
)
"""Numba's own that is used here; each has been there since version 0.60 at least."""
PART = "part"
"""The kind of a library that is kept without machine code, where numba has ``object``."""
_FUNCTIONS: Any = functions
_CODEGEN: Any = codegen
ENVIRONMENT = "_ZN08NumbaEnv"
"""How names of what compiled code refers to at run time begin."""


class KernelLibrary(codegen.JITCodeLibrary):
    """A kernel's code, linked into those that call it before any of it is optimised."""

    is_part = False
    _is_linked = False

    def add_linking_library(self, library: Any) -> None:
        """What this one calls; numba would make machine code of it."""
        if not isinstance(library, KernelLibrary):
            library._ensure_finalized()
        self._linking_libraries.append(library)

    def _get_module_for_linking(self) -> Any:
        """This one's code and all that it calls, for those that call it."""
        if self._shared_module is None:
            self._link()
            self._shared_module = shared = self._final_module.clone()
            for function in shared.functions:
                if not function.is_declaration and function.linkage == _CODEGEN.ll.Linkage.external:
                    function.linkage = "linkonce_odr"
        return self._shared_module

    def finalize(self) -> None:
        """Optimise all of it at once, and make machine code."""
        self._codegen._check_llvm_bugs()
        self._raise_if_finalized()
        self._get_module_for_linking()
        self._optimize_final_module()
        self._final_module.verify()
        self._finalize_final_module()
        own_codegen: Any = self._codegen
        for variable in self._final_module.global_variables:
            if variable.name.startswith(ENVIRONMENT):
                known = environment.lookup_environment(variable.name)
                if known is not None:
                    own_codegen.set_env(variable.name, known)

    def _link(self) -> None:
        if self._is_linked:
            return
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
            if hasattr(library, "_reload_init"):
                # what is run where a kept library is loaded, unknown to older versions
                self._reload_init.update(library._reload_init)
        self._is_linked = True

    @property
    def has_dynamic_globals(self) -> bool:
        """Whether this code holds addresses of this process, and cannot be kept."""
        names = (variable.name for variable in self._get_module_for_linking().global_variables)
        return any(name.startswith("numba.dynamic.globals") for name in names)

    def serialize_using_object_code(self) -> Any:
        """What is kept: a part's code, or as numba does."""
        if self.is_part:
            return self.name, PART, self._get_module_for_linking().as_bitcode()
        return super().serialize_using_object_code()

    @classmethod
    def of_part(cls, own_codegen: Any, name: str, code: bytes) -> KernelLibrary:
        """A part that was kept."""
        library = cls(own_codegen, name)
        library._final_module = _CODEGEN.ll.parse_bitcode(code)
        library._is_linked = True
        library.is_part = True
        return library


class NoEntry:
    """Stands for the entry of a part, which Python cannot call."""


class _Work:
    """How deep in kernels of ours that call each other the compiler is; numba's lock is held.

    ``forgotten``: parts that Python has a whole of now; code that is built on them refers to what
    they hold.
    """

    def __init__(self) -> None:
        self.depth = 0
        self.forgotten: list[Any] = []


_WORK = _Work()


def is_part() -> bool:
    """Whether what is compiled or loaded now is wanted by a kernel of ours that calls it."""
    return _WORK.depth > 1


def compile_in_parts(locator: type) -> None:
    """From now on, kernels that a locator of this class finds are compiled as this module says."""
    if not all(hasattr(owner, name) for owner, names in NEEDED for name in names):
        return
    if hasattr(dispatcher.Dispatcher.compile, "in_parts"):
        return  # once a process: twice, each kernel would be within itself
    _compile_parts(locator)
    _leave_out_entries()
    _ask_again_who_answered()
    _compare_options_as_set()


def _compile_parts(locator: type) -> None:
    """Make numba's dispatcher count how deep it is, and compile as a whole what was a part."""
    numbas = dispatcher.Dispatcher.compile

    def compile_kernel(self: Any, signature: Any) -> Any:
        with global_compiler_lock:
            # what others keep is read without us, too; what nobody keeps may be a part
            is_kept = not isinstance(self._cache, caching.NullCache)
            alone = not _is_found_by(locator, self) and (_WORK.depth == 0 or is_kept)
            if alone or _WORK.depth == 0:
                _forget_part(self, signature)
            within = _by_numba_alone if alone else _one_deeper
            with within(self.targetctx.codegen()):
                return numbas(self, signature)

    vars(compile_kernel)["in_parts"] = True
    setattr(dispatcher.Dispatcher, "compile", compile_kernel)  # noqa: B010 - for mypy it is a method


def _is_found_by(locator: type, kernel: Any) -> bool:
    implementation = getattr(kernel._cache, "_impl", None)
    return implementation is not None and isinstance(implementation.locator, locator)


def _forget_part(kernel: Any, signature: Any) -> None:
    """Python wants a whole: what was built on the part has it already."""
    types = tuple(sigutils.normalize_signature(signature)[0])
    known = kernel.overloads.get(types)
    if known is not None and isinstance(known.entry_point, NoEntry):
        _WORK.forgotten.append(kernel.overloads.pop(types))


@contextmanager
def _one_deeper(own_codegen: Any) -> Iterator[None]:
    """In a kernel of ours, with libraries of ours."""
    usual = own_codegen._library_class
    own_codegen._library_class = KernelLibrary
    _WORK.depth += 1
    try:
        yield
    finally:
        _WORK.depth -= 1
        own_codegen._library_class = usual


@contextmanager
def _by_numba_alone(own_codegen: Any) -> Iterator[None]:
    """In a function of others, which may be called by a kernel of ours."""
    usual, depth = own_codegen._library_class, _WORK.depth
    own_codegen._library_class = codegen.JITCodeLibrary
    _WORK.depth = 0
    try:
        yield
    finally:
        _WORK.depth = depth
        own_codegen._library_class = usual


def _leave_out_entries() -> None:
    """No part has a wrapper for Python, machine code, or a place in the table of entries."""
    wrapper = lowering.Lower.create_cpython_wrapper
    executable = cpu.CPUContext.get_executable
    overload = dispatcher.Dispatcher.add_overload

    def create_cpython_wrapper(self: Any, *options: Any, **named: Any) -> None:
        if not is_part():
            wrapper(self, *options, **named)

    def get_executable(self: Any, library: Any, description: Any, env: Any) -> Any:
        if is_part() and isinstance(library, KernelLibrary):
            library.is_part = True
            return NoEntry()
        return executable(self, library, description, env)

    def add_overload(self: Any, compiled: Any) -> None:
        if isinstance(compiled.entry_point, NoEntry):
            self.overloads[tuple(compiled.signature.args)] = compiled
        else:
            overload(self, compiled)

    setattr(lowering.Lower, "create_cpython_wrapper", create_cpython_wrapper)  # noqa: B010
    setattr(cpu.CPUContext, "get_executable", get_executable)  # noqa: B010
    setattr(dispatcher.Dispatcher, "add_overload", add_overload)  # noqa: B010


def _ask_again_who_answered() -> None:
    """Ask the implementation first that could take these types before."""
    numbas = functions.BaseFunction.get_call_type
    answered: dict[Any, tuple[Any, bool]] = {}

    def get_call_type(self: Any, context: Any, types: Any, named: Any) -> Any:
        if _WORK.depth == 0:
            return numbas(self, context, types, named)
        key = self.templates, types, tuple(named.items())
        if key in answered:
            signature = _ask(self, *answered[key], context, types, named)
            if signature is not None:
                return signature
        target = get_local_target(context)
        self._depth += 1  # numba counts how deep it asks, for its messages
        try:
            for template in order_by_target_specificity(target, self.templates, fnkey=self.key[0]):
                first = template.prefer_literal
                for literally in (first, not first):
                    signature = _ask(self, template, literally, context, types, named)
                    if signature is not None:
                        answered[key] = template, literally
                        return signature
        finally:
            self._depth -= 1
        return numbas(self, context, types, named)  # says what is wrong

    setattr(functions.BaseFunction, "get_call_type", get_call_type)  # noqa: B010


def _ask(
    function: Any, template: Any, literally: bool, context: Any, types: Any, named: Any
) -> Any:
    """The signature that an implementation has for these types, or None."""
    asked = template(context)
    plain = _FUNCTIONS._unlit_non_poison  # of a literal, its type
    try:
        if not literally:
            types = tuple(map(plain, types))
            named = {name: plain(one) for name, one in named.items()}
        signature = asked.apply(types, named)
    except NumbaError:
        return None
    if signature is not None:
        function._impl_keys[signature.args] = asked.get_impl_key(signature)
    return signature


def _compare_options_as_set() -> None:
    """Compare options of the compiler as they were set, before all of their values are listed."""
    equal = TargetConfig.__eq__
    digest = TargetConfig.__hash__
    digests: dict[type, int] = {}

    def are_equal(self: Any, other: Any) -> Any:
        if type(self) is type(other) and self._values == other._values:
            return True
        return equal(self, other)

    def digest_of(self: Any) -> int:
        # of the options' names alone, as in numba
        if type(self) not in digests:
            digests[type(self)] = digest(self)
        return digests[type(self)]

    setattr(TargetConfig, "__eq__", are_equal)  # noqa: B010
    setattr(TargetConfig, "__hash__", digest_of)  # noqa: B010
