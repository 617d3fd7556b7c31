"""Kernels that kernels call are parts of them, and give what they give as wholes."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from planner.shared import kernel_compiler
from planner.shared.kernel_locator import ROOT
from tests.support.processes.forked import Forked

Run = Callable[[str], str]

INNER = """
import numpy as np
from numba import njit
from planner.scene.compile_options import OWNING, SUMS

@njit(**SUMS)
def norm(values):
    total = 0.0
    for k in range(values.shape[0]):
        total += values[k] * values[k] / 3.0
    return np.sqrt(total)

@njit(**OWNING)
def checked(values):
    if values.shape[0] == 0:
        raise ValueError("no values")
    return np.zeros(values.shape[0]) + values
"""
OUTER = """
import numpy as np
from numba import njit
from planner.scene.compile_options import OWNING
from strange.inner_kernels import checked, norm

@njit(**OWNING)
def twice(values):
    return norm(checked(values)) + norm(values)
"""
NUMBA = """
import numpy as np
import planner.scene.compile_options
from numba.core.registry import cpu_target
cpu_target.target_context.refresh()
cpu_target.typing_context.refresh()
"""
BEGIN = """
import os
import sys
from pathlib import Path
import numpy as np
import planner.scene.compile_options
import planner.shared.kernel_locator as locator

os.environ["NUMBA_CACHE_DIR"] = sys.argv[1] + "/cache"
locator.CONFIG.reload_config()
locator.ROOT = Path(sys.argv[1])
locator.PACKAGES = ("strange",)
sys.path.insert(0, sys.argv[1])
from strange.inner_kernels import checked, norm
from strange.outer_kernels import twice

values = np.random.default_rng(0).random(999)

def kinds(kernel):
    return [type(one.entry_point).__name__ for one in kernel.overloads.values()]

def found(kernel):
    return sum(kernel.stats.cache_hits.values()), sum(kernel.stats.cache_misses.values())
"""


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A folder with a package of two files of kernels."""
    (tmp_path / "strange").mkdir()
    (tmp_path / "strange" / "__init__.py").touch()
    (tmp_path / "strange" / "inner_kernels.py").write_text(INNER)
    (tmp_path / "strange" / "outer_kernels.py").write_text(OUTER)
    return tmp_path


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Forked]:
    """It has imported what numba imports before it compiles, and has compiled nothing."""
    nowhere = str(tmp_path_factory.mktemp("nowhere"))
    with Forked(NUMBA, cwd=ROOT, environment={"NUMBA_CACHE_DIR": nowhere}) as python:
        yield python


@pytest.fixture
def run(python: Forked, package: Path) -> Run:
    """Runs code in a process that has compiled nothing yet; what it prints."""

    def run(code: str) -> str:
        done = python.run(BEGIN + code, str(package))
        assert done.status == 0, done.err
        return done.out

    return run


def test_what_a_kernel_calls_has_no_entry_until_python_calls_it(run: Run) -> None:
    told = run(
        """
both = twice(values)
print(kinds(twice), kinds(norm), kinds(checked))
alone = norm(values)
print(kinds(norm), both == 2 * alone, norm(checked(values)) == alone)
""",
    )
    wholes = "['builtin_function_or_method']"
    assert told == f"{wholes} ['NoEntry'] ['NoEntry']\n{wholes} True True\n"


def test_a_whole_is_the_same_whatever_was_compiled_before_it(run: Run, package: Path) -> None:
    show = """
import re
[whole] = twice.overloads.values()
names = {}
lines = whole.library.get_asm_str().splitlines()
code = "\\n".join(line for line in lines if not line.startswith("\\t."))  # instructions
# names, some with an address in them before numba 0.67
print(re.sub(r"_Z[\\w$.]+|\\d{9,}", lambda one: names.setdefault(one[0], str(len(names))), code))
"""
    last = run("twice(values)" + show)
    assert "sqrt" in last
    for kept in (package / "cache").rglob("*.nb[ci]"):
        kept.unlink()
    assert run("norm(values); checked(values); twice(values)" + show) == last


def test_a_whole_that_was_kept_has_its_constants_beside_a_part_of_the_same_number(
    run: Run,
) -> None:
    """Numba numbers what it compiles, process by process, and names constants by that number."""
    uid = run("twice(values)\n[part] = checked.overloads.values()\nprint(part.fndesc.uid)")
    pin = f"""
import itertools
from numba.core.bytecode import FunctionIdentity
FunctionIdentity._unique_ids = itertools.count({uid})
"""
    whole = "[whole] = checked.overloads.values()\nprint(whole.fndesc.uid)"
    assert run(f"{pin}checked(values)\n{whole}") == uid
    told = run("twice(values)\nprint((checked(values) == values).all(), found(checked))")
    assert told == "True (1, 0)\n"


def test_a_changed_kernel_is_built_on_parts_that_were_kept(run: Run, package: Path) -> None:
    before = run("print(twice(values), found(norm), found(checked))")
    assert before.endswith(" (0, 1) (0, 1)\n")
    (package / "strange" / "outer_kernels.py").write_text(OUTER + "\n# changed\n")
    after = run("print(twice(values), found(norm), found(checked), found(twice))")
    assert after == before.replace("(0, 1) (0, 1)", "(1, 0) (1, 0) (0, 1)")


def test_a_part_that_was_kept_is_no_whole_for_python(run: Run, package: Path) -> None:
    first = run("twice(values); print(norm(values), found(norm))")
    assert first.endswith(" (0, 2)\n")  # as a part, and as a whole
    assert run("print(norm(values), found(norm))") == first.replace("(0, 2)", "(1, 0)")
    (package / "strange" / "outer_kernels.py").write_text(OUTER + "\n# changed\n")
    run("twice(values); norm(values); assert found(norm) == (1, 0), norm.stats")


@pytest.mark.parametrize("first", ["twice(values)", "pass", "checked(values)"])
def test_what_a_part_refuses_is_told_compiled_and_kept(run: Run, first: str) -> None:
    code = f"""
{first}
try:
    twice(values[:0])
except ValueError as refused:
    print(refused)
"""
    assert run(code) == "no values\n"
    assert run(code) == "no values\n"


def test_functions_of_others_are_compiled_by_numba_and_built_on_ours(run: Run) -> None:
    told = run(
        """
from numba import njit

@njit
def others(values):
    return checked(values)[0] + np.zeros(values.shape[0])[0] - values[0]

twice(values)
print(others(values), type(others.overloads[others.signatures[0]].library).__name__)
print(len(checked(values)), kinds(checked))
""",
    )
    assert told == "0.0 JITCodeLibrary\n999 ['builtin_function_or_method']\n"


def test_a_function_of_others_that_was_a_part_is_compiled_when_python_calls_it(
    run: Run,
    package: Path,
) -> None:
    others = "@njit\ndef other(values):\n    return norm(values)\n\n"
    twice = "@njit(**OWNING)\ndef twice(values):\n    return other(values)\n"
    head = OUTER.partition("@njit")[0]
    (package / "strange" / "outer_kernels.py").write_text(head + others + twice)
    told = run("from strange.outer_kernels import other; print(twice(values) == other(values))")
    assert told == "True\n"


def test_what_others_keep_is_kept_as_numba_does(run: Run, package: Path) -> None:
    """A function of others with a cache of its own: any program may read that, without us."""
    (package / "foreign.py").write_text(
        "from numba import njit\n\n@njit(cache=True)\ndef other(values):\n    return values.sum()\n"
    )
    source = package / "strange" / "outer_kernels.py"
    source.write_text(OUTER.replace("norm(checked(values))", "other(checked(values))"))
    source.write_text(
        source.read_text().replace("import njit", "import njit\nfrom foreign import other")
    )
    run("twice(values)")
    told = run("from foreign import other; print(other(values) > 0.0, found(other))")
    assert told == "True (1, 0)\n"


def test_what_a_forgotten_part_held_is_there_for_those_built_on_it(run: Run, package: Path) -> None:
    """What a kernel prints is found by its environment, which is its own."""
    source = package / "strange" / "outer_kernels.py"
    saying = "@njit(**OWNING)\ndef say(values):\n    print('there are', values.shape[0])\n\n"
    head = OUTER.partition("@njit")[0]
    twice = "@njit(**OWNING)\ndef twice(values):\n    say(values)\n"
    source.write_text(head + saying + twice)
    code = """
import gc
from strange.outer_kernels import say
twice(values)
say(values)
gc.collect()
spare = [object() for _ in range(9999)]
twice(values)
"""
    assert run(code) == "there are 999\n" * 3
    assert run(code) == "there are 999\n" * 3


def test_kernels_that_are_prepared_twice_are_wholes_for_python(run: Run) -> None:
    """A module that was imported again prepared them once more: each was a part of itself."""
    told = run(
        """
import importlib
importlib.reload(planner.scene.compile_options)
locator.prepare_kernels()
print(twice(values) > 0.0, kinds(twice), kinds(norm))
""",
    )
    assert told == "True ['builtin_function_or_method'] ['NoEntry']\n"


def test_after_a_kernel_that_is_refused_others_are_compiled(run: Run) -> None:
    told = run(
        """
from numba.core.errors import TypingError
try:
    twice("words")
except TypingError as refused:
    print("No implementation" in str(refused) or "Unknown attribute" in str(refused))
print(twice(values) > 0.0, kinds(norm))
""",
    )
    assert told == "True\nTrue ['NoEntry']\n"


def test_a_numba_that_lacks_what_is_used_compiles_as_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    usual = kernel_compiler.dispatcher.Dispatcher.compile
    monkeypatch.setattr(kernel_compiler, "NEEDED", ((object, ("no_such_name",)),))
    kernel_compiler.compile_in_parts(object)
    assert kernel_compiler.dispatcher.Dispatcher.compile is usual
