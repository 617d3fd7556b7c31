"""Workers of a sweep: processes of this machine, or a Dask cluster.

Both are `concurrent.futures.Executor`s. Dask is the optional extra ``cluster``.
"""

from __future__ import annotations

from concurrent.futures import Executor, ProcessPoolExecutor
from typing import Any, Final

from navigation.machine.child import FRESH, end_with_parent
from navigation.sweep.variations import SweepError

CONNECT_S: Final = 10.0


def local_executor(workers: int) -> ProcessPoolExecutor:
    """Fresh processes that end with this one."""
    return ProcessPoolExecutor(workers, mp_context=FRESH, initializer=end_with_parent)


class Cluster:
    """A Dask cluster at its scheduler's address; ``SweepError`` if it cannot be reached."""

    def __init__(self, address: str) -> None:
        try:
            import distributed
        except ImportError:
            raise SweepError(
                "a cluster needs Dask: pip install 'clearway[cluster]', on every worker too"
            ) from None
        try:
            module: Any = distributed
            self._client = module.Client(address, timeout=CONNECT_S)
        except (OSError, ValueError, TimeoutError) as error:
            raise SweepError(f"scheduler {address}: {error}") from None

    def executor(self) -> Executor:
        """Its executor; the scheduler itself reassigns the work of a dead worker."""
        executor: Executor = self._client.get_executor(pure=False)
        return executor

    def workers(self) -> int:
        """Number of runs it can do at a time."""
        return max(1, sum(int(threads) for threads in self._client.nthreads().values()))

    def close(self) -> None:
        """Leave the cluster."""
        self._client.close()
