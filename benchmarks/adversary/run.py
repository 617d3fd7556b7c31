"""One attack, once: a folder, a rig, the attack, the judgement. Choices follow from the seed."""

from __future__ import annotations

import shutil
import tempfile
import time
import zlib
from pathlib import Path

import numpy as np

from benchmarks.adversary.attacks.attack import Attack
from benchmarks.adversary.bars import Outcome
from benchmarks.adversary.driver_rig import DriverRig
from benchmarks.adversary.processes import ProcessError
from benchmarks.adversary.rig import Rig
from benchmarks.adversary.scene import DRIVER_ERRANDS, ERRANDS, read_config, write_config
from navigation.run.kernels.warm_up import warm_up


def prepare() -> None:
    """Compile the kernels where that has not been done: no run shall wait for it."""
    with tempfile.TemporaryDirectory(prefix="clearway-judge-") as folder:
        warm_up(read_config(write_config(Path(folder), ERRANDS[0])), print)


def run_attack(attack: Attack, seed: int, keep: Path | None = None) -> Outcome:
    """What came of it; ``keep``: where the run's folder is left."""
    began_s = time.monotonic()
    rng = np.random.default_rng([seed, zlib.crc32(attack.name.encode())])
    driver = attack.needs.driver
    errand = DRIVER_ERRANDS[driver] if driver else ERRANDS[int(rng.integers(len(ERRANDS)))]
    new_rig = DriverRig if driver else Rig
    onset_m = float(rng.uniform(*attack.onset_m))
    outcome = Outcome(attack.name, seed)
    folder = Path(tempfile.mkdtemp(prefix="clearway-judge-"))
    try:
        with new_rig(folder, errand, attack.needs, int(rng.integers(1 << 31))) as rig:
            if attack.before is not None:
                attack.before(rig)
            rig.start_daemon()
            rig.drive(onset_m, may_stand=attack.before is not None)
            attack.act(rig)
            rig.judged(outcome)
    except ProcessError as error:
        outcome.failures.append(str(error))
    finally:
        if keep is not None:
            left_out = shutil.ignore_patterns("*.sock", "port")
            shutil.copytree(folder, keep, ignore=left_out, dirs_exist_ok=True)
        shutil.rmtree(folder, ignore_errors=True)
    outcome.took_s = time.monotonic() - began_s
    return outcome
