"""Stand-ins for the work of a sweep, importable by its workers."""

from __future__ import annotations

import os
import signal
from dataclasses import asdict
from pathlib import Path

from navigation.config import Config
from navigation.sweep.runs import Row
from navigation.sweep.variations import Variation


def quick(_config: Config, v: Variation) -> tuple[Row, ...]:
    """A row for each robot without a run."""
    return tuple(
        Row(state="done", reason="", duration_s=10.0 + v.run, robot=name, **asdict(one))
        for name, one in v.robots.items()
    )


def once_killed(config: Config, v: Variation) -> tuple[Row, ...]:
    """As if somebody had killed the worker at run 3: the first time only."""
    mark = config.recording.runs_dir / "killed"
    if v.run == 3 and not mark.exists():
        mark.write_text("")
        os.kill(os.getpid(), signal.SIGKILL)
    return quick(config, v)


def always_killed(config: Config, v: Variation) -> tuple[Row, ...]:
    """Run 3 kills its worker whenever it is tried; each try leaves a mark."""
    if v.run == 3:
        tries = config.recording.runs_dir
        Path(tries / f"try-{len(list(tries.glob('try-*')))}").write_text("")
        os.kill(os.getpid(), signal.SIGKILL)
    return quick(config, v)


def broken(config: Config, v: Variation) -> tuple[Row, ...]:
    """Run 3 has a bug."""
    if v.run == 3:
        raise RuntimeError("a bug in run 3")
    return quick(config, v)
