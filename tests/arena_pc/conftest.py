"""What the tests on the arena PC begin with: a machine of their own, and its USB sockets."""

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.arena_pc.machine.pc import ArenaPC
from tests.arena_pc.machine.snapshot import BOOTED, State, restored
from tests.arena_pc.machine.usb_sockets import UsbSockets


@pytest.fixture(scope="session")
def image() -> Path:
    """The folder with the machine's disks."""
    return Path(os.environ["CLEARWAY_ARENA_PC"])


@pytest.fixture
def pc(request: pytest.FixtureRequest, image: Path) -> Iterator[ArenaPC]:
    """The test's machine, booted, or in the state that its module names."""
    state: State = getattr(request.module, "STATE", BOOTED)
    # a short name: a socket's has at most 107 characters
    with (
        tempfile.TemporaryDirectory(prefix="arena-") as work,
        restored(image, state, Path(work)) as pc,
    ):
        yield pc
        print(pc.logs())  # shown of a test that failed


@pytest.fixture
def usb(pc: ArenaPC) -> Iterator[UsbSockets]:
    """The machine's USB sockets."""
    sockets = UsbSockets(pc)
    yield sockets
    sockets.close()
