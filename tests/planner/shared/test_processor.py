"""The processor that kernels are compiled for: the highest common one, unless the user has said."""

import subprocess
import sys

import pytest

from planner.shared.processor import LEVELS, choose_processor, common_processor

V2 = " ".join(LEVELS["x86-64-v2"])
V3 = " ".join(LEVELS["x86-64-v3"] | LEVELS["x86-64-v2"])


def cpuinfo(*processors: str) -> str:
    return "".join(f"processor : {n}\nflags\t\t: fpu {p}\n\n" for n, p in enumerate(processors))


@pytest.mark.parametrize(
    ("machine", "processors", "level"),
    [
        ("x86_64", [V3, V3], "x86-64-v3"),
        ("x86_64", [V3, V2], "x86-64-v2"),  # the weaker of two counts
        ("x86_64", [V2], "x86-64-v2"),
        ("x86_64", ["sse2"], None),
        ("x86_64", [" ".join(LEVELS["x86-64-v3"])], None),  # v3 without v2 is no level
        ("x86_64", [], None),
        ("aarch64", [], "generic"),
        ("riscv64", [V3], None),
    ],
)
def test_the_highest_level_that_every_processor_has(
    machine: str, processors: list[str], level: str | None
) -> None:
    assert common_processor(machine, cpuinfo(*processors)) == level


def test_a_processor_named_by_the_user_is_left_alone() -> None:
    assert choose_processor({"NUMBA_CPU_NAME": "znver3"}) == "znver3"
    assert choose_processor({"NUMBA_CPU_FEATURES": "+avx512f"}) is None


def test_a_program_that_has_kernels_of_its_own_keeps_its_processor() -> None:
    code = (
        "import numba\n"
        "numba.njit(lambda x: x)(1)\n"
        "import planner.scene.compile_options\n"
        "assert numba.config.CPU_NAME is None\n"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert told.returncode == 0, told.stderr
