"""The thread that alone owns the serial port, around the sans-IO ``HostConnection``.

- Any thread may queue orders; the emergency stop bypasses the queue. Only this thread touches the
  port or the connection.
- The thread sends no lease of its own: a control loop that hangs stops the robot.
- A broken port is closed, its reason reported, and the same path opened again with growing pauses.
  Seconds are those of ``clock``; metres and radians.
"""

from __future__ import annotations

import contextlib
import math
import os
import random
import select
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Final

import serial

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.events import Event, LinkChanged
from firmware_protocol.host.state import LinkState
from firmware_protocol.wire.errors import LocalError
from firmware_protocol.wire.framing import MAX_WIRE
from navigation.link.link_snapshot import LinkSnapshot, snapshot_of
from navigation.link.port_faults import PORT_FAULTS
from navigation.link.robot_link import Order, RobotLink
from navigation.link.serial_port import PortError, PortNotReadyError, open_port
from navigation.shared.supervisor import in_words
from navigation.shared.system import require_linux

REOPEN_FIRST_S: Final = 0.1
REOPEN_LAST_S: Final = 2.0
EVENTS_KEPT: Final = 500


class SerialLink(RobotLink):
    """One robot on one serial port; a context manager that opens and closes.

    ``wait_for_port``: wait for a port that is not ready at opening, like one that breaks later.
    Needs Linux: ``NeedsLinuxError`` on other systems.
    """

    def __init__(
        self,
        port: str,
        baud: int = 115_200,
        *,
        clock: Callable[[], float] = time.monotonic,
        wait_for_port: bool = False,
    ) -> None:
        require_linux("a serial link")
        super().__init__(clock)
        self.path = port
        self.baud = baud
        self._wait_for_port = wait_for_port
        self._host = HostConnection(random.SystemRandom(), baud)
        self._serial: serial.Serial | None = None
        self._unsent = b""
        self._reopen_s = 0.0
        self._reopen_wait_s = REOPEN_FIRST_S
        self._port_fault = "the port is not open"
        self._orders: deque[Order] = deque()
        self._estop = threading.Event()
        self._reset_lock = threading.Lock()
        self._resets = self._resets_taken = self._resets_published = 0
        """Orders to leave the emergency stop: given, carried out, and known to the snapshot."""
        self._events: deque[Event] = deque(maxlen=EVENTS_KEPT)
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._wake_out = self._wake_in = -1
        self._wake_lock = threading.Lock()
        self._published: tuple[LinkSnapshot, float, float] = (
            LinkSnapshot(LinkState.CLOSED, self._port_fault, math.inf),
            -math.inf,
            -math.inf,
        )
        self._crash: BaseException | None = None
        self._late_s = 0.0
        self._due_s = math.inf
        self._measured_s = -math.inf

    # Life.

    def open(self) -> None:
        """Open the port and start the thread; PortError if the port cannot be used."""
        if self._thread is not None:
            raise PortError(f"serial port {self.path}: is open already")
        port = None
        try:
            port = open_port(self.path, self.baud)
        except PortNotReadyError as error:
            if not self._wait_for_port:
                raise
            self._port_fault = str(error)
        self._start_thread(port)

    def _start_thread(self, port: serial.Serial | None) -> None:
        """Start with the port; without one the thread tries to open it."""
        self._serial = port
        self._wake_out, self._wake_in = os.pipe()
        os.set_blocking(self._wake_out, False)
        os.set_blocking(self._wake_in, False)
        self._stop.clear()
        if port is not None:
            self._host.open(self._clock())
        self._publish()
        self._thread = threading.Thread(target=self._run, name="serial link", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop the thread and close the port; the robot stops when its lease ends."""
        thread = self._thread
        if thread is None:
            return
        self._stop.set()
        self._wake()
        thread.join()
        with self._wake_lock:
            if self._thread is thread:
                self._thread = None
                os.close(self._wake_out)
                os.close(self._wake_in)

    def __enter__(self) -> SerialLink:
        self.open()
        return self

    def __exit__(self, *_exc: object) -> None:
        self.close()

    # Orders, from any thread.

    def start(self) -> None:
        """Drive the mission (again, after a pause or a lapsed lease)."""

        def drive(host: HostConnection, now_s: float) -> None:
            with contextlib.suppress(LocalError):  # the mission may have become void
                host.start(now_s)

        self._order(drive)

    def estop(self) -> None:
        """Stop in an emergency: before every other order, repeated until confirmed."""
        self._estop.set()
        super().estop()  # once more in its turn: an earlier re-arm may wait, and would undo it

    def reset_estop(self) -> None:
        """Leave the emergency stop; the mission is void."""
        with self._reset_lock:
            self._resets += 1
            self._orders.append(HostConnection.reset_estop)
        self._wake()

    # Known facts, for any thread.

    def snapshot(self) -> LinkSnapshot:
        """Present state, ages counted up to now."""
        resetting = self._resets != self._resets_published
        snapshot, heard_s, status_s = self._published
        now_s = self._clock()
        return replace(
            snapshot,
            heard_age_s=now_s - heard_s,
            status_age_s=now_s - status_s,
            leaving_estop=snapshot.leaving_estop or resetting,
        )

    def late_s(self) -> float:
        """Longest delay in waking the thread since the last call."""
        late_s, self._late_s = self._late_s, 0.0
        return late_s

    def late_since_s(self) -> float:
        """Time since which the thread has unfinished work, or will have; infinity while closed."""
        return self._due_s

    def failure(self) -> str | None:
        """Error that ended the thread, in words; None while it runs."""
        return None if self._crash is None else in_words(self._crash)

    def restart(self) -> None:
        """Close what an error left and open again; a missing port is waited for."""
        self.close()
        self._crash = None
        self._orders.clear()
        self._start_thread(None)

    def events(self) -> list[Event]:
        """Events since the last call, oldest first (the newest 500 are kept)."""
        out = []
        with contextlib.suppress(IndexError):
            while True:
                out.append(self._events.popleft())
        return out

    # The thread.

    def _run(self) -> None:
        try:
            while not self._stop.is_set():
                self._cycle()
        except Exception as error:  # noqa: BLE001 - said by the control loop, which restarts it
            self._crash = error
        finally:
            self._due_s = math.inf
            self._shut("the link was closed")
            self._publish()

    def _cycle(self) -> None:
        self.turns += 1
        self._due_s = min(self._due_s, self._clock())
        self._take_orders()
        now_s = self._clock()
        if self._serial is None:
            self._reopen(now_s)
        if self._serial is not None:
            try:
                self._exchange(self._serial)
            except PORT_FAULTS as error:
                self._shut(f"the port {self.path} broke: {error}")
        self._publish()
        self._wait(self._clock())

    def _take_orders(self) -> None:
        if self._estop.is_set():
            self._estop.clear()
            self._host.estop()
        with self._reset_lock:
            resets = self._resets
        while self._orders:
            order = self._orders.popleft()
            if not self._estop.is_set():
                order(self._host, self._clock())
        self._resets_taken = resets

    def _exchange(self, port: serial.Serial) -> None:
        data = port.read(4096)
        now_s = self._clock()
        if data:
            self._host.receive_bytes(data, now_s)
        self._host.tick(now_s)
        while True:
            if self._unsent:
                if not select.select([], [port], [], 0)[1]:
                    return
                self._unsent = self._unsent[port.write(self._unsent) or 0 :]
                if self._unsent:
                    return
                self._measure_pose()
            if port.out_waiting > MAX_WIRE and not self._host.estop_pending:
                return
            self._unsent = self._host.bytes_to_send(self._clock())
            if not self._unsent:
                return

    def _measure_pose(self) -> None:
        captured_s = self._host.pose_captured_s
        if captured_s > self._measured_s:
            self._measured_s = captured_s
            self.capture_to_wire_s.append(self._clock() - captured_s)

    def _wait(self, now_s: float) -> None:
        ports = [] if self._serial is None else [self._serial]
        watched: list[int | serial.Serial] = [self._wake_out, *ports]
        due_s = self._host.deadline_s(now_s) if ports else self._reopen_s
        timeout_s = max(0.0, min(due_s - now_s, 0.1))
        self._due_s = now_s + timeout_s
        if self._orders or self._estop.is_set() or self._stop.is_set():
            timeout_s, self._due_s = 0.0, now_s
        try:
            writing = ports if self._unsent else []
            ready, writable, _ = select.select(watched, writing, [], timeout_s)
        except PORT_FAULTS as error:
            self._shut(f"the port {self.path} broke: {error}")
            return
        if not (ready or writable):
            self._late_s = max(self._late_s, self._clock() - now_s - timeout_s)
        if self._wake_out in ready:
            with contextlib.suppress(BlockingIOError):
                os.read(self._wake_out, 4096)

    def _reopen(self, now_s: float) -> None:
        if now_s < self._reopen_s:
            return
        try:
            self._serial = open_port(self.path, self.baud)
        except PortError as error:
            self._port_fault = str(error)
            self._reopen_s = now_s + self._reopen_wait_s
            self._reopen_wait_s = min(REOPEN_LAST_S, 2.0 * self._reopen_wait_s)
            return
        self._reopen_wait_s = REOPEN_FIRST_S
        self._host.open(now_s)

    def _shut(self, reason: str) -> None:
        self._host.close(reason)
        self._port_fault = reason
        self._unsent = b""
        self._reopen_s = self._clock() + self._reopen_wait_s
        port, self._serial = self._serial, None
        if port is not None:
            # a port that has hung up may fail to close
            with contextlib.suppress(*PORT_FAULTS):
                port.close()

    def _publish(self) -> None:
        host = self._host
        while (event := host.next_event()) is not None:
            self._events.append(event)
        now_s = self._clock()
        snapshot = snapshot_of(
            host, now_s, port_fault=self._port_fault, estop_waits=self._estop.is_set()
        )
        self._published = (snapshot, host.heard_s, host.status_s)
        self._resets_published = self._resets_taken

    def _order(self, order: Order) -> None:
        self._orders.append(order)
        self._wake()

    def _wake(self) -> None:
        # the lock keeps a late order out of a pipe that close() has closed
        with self._wake_lock, contextlib.suppress(BlockingIOError):
            if self._thread is not None:
                self._due_s = min(self._due_s, self._clock())
                os.write(self._wake_in, b"!")


__all__ = ["Event", "LinkChanged", "LinkSnapshot", "PortError", "SerialLink"]
