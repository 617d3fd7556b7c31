"""The runs: every shipped configuration that runs in virtual time, with each trouble and seed."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Final

from benchmarks.same_runs.program import count_robots, runs_virtually
from benchmarks.same_runs.troubles import TROUBLES, Trouble
from navigation.config import Config, load_config

CONFIGS: Final = Path(__file__).parents[2] / "configs"
NOT_CONFIGURATIONS: Final = ("simulation_calibration",)
NO_TROUBLE: Final = "none"


@dataclass(frozen=True, slots=True)
class Case:
    """One run."""

    config: str
    trouble: str
    seed: int
    pictures: bool = False

    @property
    def name(self) -> str:
        """The name it is kept by: ``crossing/stop/3``, with ``/drawn`` where pictures are drawn."""
        words = [self.config, self.trouble, str(self.seed)]
        return "/".join([*words, "drawn"] if self.pictures else words)

    def prepared(self) -> Config:
        """The configuration with its seed and what the trouble changes in it."""
        config = _loaded(self.config)
        assert config.simulation is not None
        seeded = config.simulation.model_copy(update={"seed": config.simulation.seed + self.seed})
        return TROUBLES[self.trouble].prepare(config.model_copy(update={"simulation": seeded}))

    def chance(self) -> random.Random:
        """A generator for this run's robot and times: equal for equal names, in every process."""
        return random.Random(self.name)


def all_cases(seeds: int) -> list[Case]:
    """Every run: without pictures with each seed, with pictures with one."""
    cases: list[Case] = []
    for config in _configs():
        robots = count_robots(_loaded(config))
        for name, trouble in TROUBLES.items():
            if trouble.least_robots <= robots:
                cases += _of_trouble(config, name, trouble, seeds)
    return cases


def sample(cases: Sequence[Case]) -> list[Case]:
    """Each configuration undisturbed, and each trouble once, without pictures."""
    drawn_not = [one for one in cases if not one.pictures and one.seed == 0]
    chosen = [one for one in drawn_not if one.trouble == NO_TROUBLE]
    for number, name in enumerate(TROUBLES):
        of_trouble = [one for one in drawn_not if one.trouble == name != NO_TROUBLE]
        chosen += of_trouble[number % max(len(of_trouble), 1) :][:1]
    return chosen


def _of_trouble(config: str, name: str, trouble: Trouble, seeds: int) -> Iterator[Case]:
    if trouble.without_pictures:
        yield from (Case(config, name, seed) for seed in range(seeds))
    if trouble.with_pictures:
        yield Case(config, name, 0, pictures=True)


def _configs() -> list[str]:
    names = sorted(path.stem for path in CONFIGS.glob("*.yaml"))
    return [one for one in names if one not in NOT_CONFIGURATIONS and runs_virtually(_loaded(one))]


@lru_cache(maxsize=64)
def _loaded(name: str) -> Config:
    return load_config(CONFIGS / f"{name}.yaml", {})
