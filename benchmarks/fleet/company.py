"""What company costs: driving several robots together against each of them alone, in virtual time.

    python -m benchmarks.fleet.company [CONFIG ...] [--rounds N]

Every robot of the configuration (`configs/fleet.yaml` where none is given) drives through the whole
running program, once with the others and once alone in the same arena, from its start to its
goal. The loss is the sum of the durations together over the sum alone: what waiting, detours,
planning for all and driving as carefully as company asks for take. For each robot: seconds
together and alone, how long it drove, stood at a gate, or was held or planned for, and the metres
it drove. ``--rounds`` changes how often a plan is shortened.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from navigation.config import Config, load_config
from navigation.config.several.each_robot import each_robot
from navigation.fleet import planning
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RunState
from navigation.mission.mission import State
from navigation.run.virtual_run import run_virtually

FLEET = Path(__file__).parents[2] / "configs" / "fleet.yaml"


@dataclass(slots=True)
class Watch:
    """What each robot did with its time, until it was at its goal."""

    arrived_s: dict[str, float] = field(default_factory=dict)
    spent_s: dict[str, dict[str, float]] = field(
        default_factory=lambda: defaultdict(lambda: defaultdict(float))
    )
    driven_m: dict[str, float] = field(default_factory=dict)
    before_s: float = 0.0

    def look(self, daemon: Daemon, now: RunState) -> bool:
        """After each cycle; never ends the run."""
        step_s, self.before_s = now.time_s - self.before_s, now.time_s
        for name, one in now.robots.items():
            if name in self.arrived_s:
                continue
            if one.mission.state is State.DONE:
                self.arrived_s[name] = now.time_s
                truths = daemon.world.truths
                track = truths[name].track()
                self.driven_m[name] = float(np.hypot(*np.diff(track[:, 1:3], axis=0).T).sum())
                continue
            what = "at a gate" if name in now.waits else one.mission.state.value
            self.spent_s[name][what] += step_s
        return False


def measure(config: Config) -> list[str]:
    """A row for each robot, and the sums."""
    watch = Watch()
    report = run_virtually(config, look=watch.look)
    rows, together_s, alone_s = [], 0.0, 0.0
    for name, one in each_robot(config).items():
        alone = run_virtually(one)
        here_s = watch.arrived_s.get(name, report.duration_s)
        together_s += here_s
        alone_s += alone.duration_s
        spent = ", ".join(f"{what} {s:.1f}" for what, s in sorted(watch.spent_s[name].items()))
        rows.append(
            f"| {name} | {here_s:.1f} | {alone.duration_s:.1f} | {here_s / alone.duration_s:.2f}"
            f" | {watch.driven_m.get(name, 0.0):.2f} | {spent} |"
        )
    loss = together_s / alone_s
    gap_mm = 1e3 * (report.least_gap_m or 0.0)
    rows.append(
        f"| all | {together_s:.1f} | {alone_s:.1f} | {loss:.2f} | | {report.state}, planned"
        f" {report.rounds} times, least gap {gap_mm:.1f} mm |"
    )
    return rows


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("configs", nargs="*", type=Path, default=[FLEET])
    parser.add_argument("--rounds", type=int, default=planning.ROUNDS)
    given = parser.parse_args()
    planning.ROUNDS = given.rounds  # type: ignore[misc]
    print("| robot | together, s | alone, s | loss | driven, m | what the time went to, s |")
    print("|---|---|---|---|---|---|")
    for file in given.configs:
        for row in measure(load_config(file, {})):
            print(row, flush=True)


if __name__ == "__main__":
    main()
