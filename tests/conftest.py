"""What every test may use: the folder of real pictures and maps, and the rule on skips.

Every process that runs tests has a folder of its own for sockets and journals, so that several of
them, and a daemon that happens to run on this machine, keep out of each other's way.
"""

import gc
import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from navigation.config.secrecy import secrets
from tests.support.processes.forked import spent_s

settings.register_profile(
    "default", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("default")

# hundreds of tests start our programs: their byte code is kept, whatever the shell says
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

FAIL_ON_SKIP = bool(os.environ.get("CLEARWAY_FAIL_ON_SKIP"))

# these need a machine's disks, which `make arena-pc` builds
collect_ignore_glob = [] if os.environ.get("CLEARWAY_ARENA_PC") else ["arena_pc/*"]


@pytest.fixture(autouse=True)
def _secrets_stay_in_their_test() -> Iterator[None]:
    """A token `space` of one test's configuration would be left out of the next one's sentences."""
    before = secrets.known()
    yield
    secrets._known = before


@pytest.fixture(autouse=True, scope="session")
def _folders_of_its_own() -> Iterator[None]:
    """For the control socket, whose path must be short, and for journals."""
    folder = tempfile.mkdtemp(prefix="cw-")
    own = pytest.MonkeyPatch()
    for name in ("XDG_RUNTIME_DIR", "XDG_STATE_HOME"):
        own.setenv(name, folder)
    for name in ("RUNTIME_DIRECTORY", "STATE_DIRECTORY"):
        own.delenv(name, raising=False)
    yield
    own.undo()
    shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture(autouse=True)
def _stops_stay_in_their_test(_folders_of_its_own: None) -> Iterator[None]:
    """A robot that one test has stopped would wait for its re-arm in the next one."""
    yield
    shutil.rmtree(Path(os.environ["XDG_STATE_HOME"]) / "clearway" / "stops", ignore_errors=True)


@pytest.fixture(autouse=True, scope="session")
def _ctrl_c_is_heard() -> Iterator[None]:
    """A shell that starts the tests in the background lets them, and their children, ignore it."""
    before = signal.getsignal(signal.SIGINT)
    if before is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="session")
def real_data() -> Path:
    """The folder of real pictures and maps that CLEARWAY_REAL_DATA names."""
    folder = os.environ.get("CLEARWAY_REAL_DATA")
    if not folder:
        pytest.skip("CLEARWAY_REAL_DATA is not set: no real pictures and maps here")
    return Path(folder)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Slow files first, so that workers end together; tests that lack real data are left out."""
    items.sort(key=lambda item: item.get_closest_marker("slow") is None)
    if not FAIL_ON_SKIP or os.environ.get("CLEARWAY_REAL_DATA"):
        return
    with_data = [item for item in items if "real_data" in getattr(item, "fixturenames", ())]
    if with_data:
        config.hook.pytest_deselected(items=with_data)
        items[:] = [item for item in items if item not in with_data]


@pytest.hookimpl(trylast=True)
def pytest_collection_finish() -> None:
    """Modules and collected tests stay to the end: keep the garbage collector out of them."""
    gc.collect()
    gc.freeze()


_spent_s = pytest.StashKey[float]()


def processor_s() -> float:
    """The processor time of this process, of all its children and programs that have ended."""
    return sum(os.times()[:4]) + spent_s()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    item.stash[_spent_s] = processor_s()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> None:
    """Leave each test's processor time in ``--junitxml``, for ``benchmarks.suite``."""
    if call.when == "teardown":
        item.user_properties.append(("processor_s", processor_s() - item.stash[_spent_s]))


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """With CLEARWAY_FAIL_ON_SKIP a skipped test fails the run."""
    if not FAIL_ON_SKIP or exitstatus != pytest.ExitCode.OK:
        return
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if reporter is not None and reporter.stats.get("skipped"):
        reporter.write_line("skipped tests fail this run: CLEARWAY_FAIL_ON_SKIP is set", red=True)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
