"""Kernels compile in processes of their own, and how far they have come is told."""

import multiprocessing
import signal
import sys
import time
from multiprocessing.context import SpawnProcess

import numba
import pytest

from navigation.machine.child import start_child
from navigation.run.kernels import compiling
from navigation.run.kernels.compiling import CompileProgress, compile_parts


def define_kernels(count: int, pause_s: float) -> None:
    """Compile so many kernels that pass for the planner's."""
    for number in range(count):
        namespace = {"__name__": "planner.test_kernels"}
        exec(f"def kernel_{number}(x):\n    return x + {number}\n", namespace)
        numba.njit(namespace[f"kernel_{number}"])(number)
        time.sleep(pause_s)  # a kernel that takes longer to compile


def test_every_kernel_of_ours_is_counted_in_whatever_process() -> None:
    parts = {"a": (define_kernels, (3, 0.0)), "b": (define_kernels, (5, 0.3))}
    seen = list(compile_parts(parts))
    done = [progress.done for progress in seen]
    assert done == sorted(done)
    # both have compiled kernels 0 to 2, which are one kernel each
    assert seen[-1].done == 5
    assert seen[-1].known == 5
    assert set(seen[-1].ended) == {"a", "b"}
    assert seen[-1].failed == ()


def test_a_part_that_cannot_be_compiled_is_named() -> None:
    last = list(compile_parts({"good": (define_kernels, (1, 0.0)), "bad": (sys.exit, (3,))}))[-1]
    assert last.failed == ("bad",)
    assert last.done == 1


def test_giving_up_ends_the_processes() -> None:
    begin_s = time.monotonic()
    running = compile_parts({"slow": (time.sleep, (60.0,)), "quick": (define_kernels, (1, 0.0))})
    next(running)
    running.close()
    assert time.monotonic() - begin_s < 30.0


class Interrupting:
    """An interrupt while it is sent to the process that it is an argument of."""

    def __reduce__(self) -> tuple[type, tuple[()]]:
        signal.raise_signal(signal.SIGINT)
        return int, ()


def test_an_interrupt_waits_until_all_processes_are_started_and_then_ends_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    started = []

    def start(*given: object) -> SpawnProcess:
        child = start_child(*given)  # type: ignore[arg-type]
        started.append(child)
        return child

    monkeypatch.setattr(compiling, "start_child", start)
    parts = {"slow": (time.sleep, (60.0,)), "interrupted": (abs, (Interrupting(),))}
    with pytest.raises(KeyboardInterrupt):
        next(compile_parts(parts))
    assert len(started) == 2
    assert multiprocessing.active_children() == []


@pytest.mark.parametrize(
    ("progress", "text"),
    [
        (CompileProgress(0, 600, 9.0), "0 of 600 kernels"),
        (CompileProgress(20, 600, 9.0), "20 of 600 kernels"),  # too early to tell
        (CompileProgress(150, 600, 30.0), "150 of 600 kernels, about 90 s left"),
    ],
)
def test_it_says_how_much_is_left(progress: CompileProgress, text: str) -> None:
    assert str(progress) == text
