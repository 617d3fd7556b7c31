"""The robot behind commands of bytes on MicroPython's stdin.

    micropython micropython_commands.py FOLDER_OF_CLEARWAY

A command is a letter, the time (u32 microseconds), a length (u16) and so many bytes; the answer is
a length (u16) and bytes. Under MicroPython every call of the robot runs with the heap locked, so
that one that allocates ends with an exception. Numbers are little-endian.

I  boot id, reset cause, schema, ten settings: a robot that has just started
R  bytes of the line        F  -> the frame that is due        S  left and right travel (i32, um)
T  a tick                   E  reason: an emergency stop       V  -> its state, as VIEW says
M  -> bytes of the heap in use, after a collection; calls of S, their total and longest time (us)
"""

import gc
import struct
import sys
import time

ticks_us = getattr(time, "ticks_us", lambda: 0)
SETTINGS = "<IBII9H"
VIEW = "<10Hiihh3H7B"
TIME = 0x3FFFFFFF


class Commands:
    """One board: ``modules`` are the package's ``link``, ``robot`` and ``settings``.

    ``lock`` locks the heap and unlocks it.
    """

    def __init__(self, modules, lock):  # type: ignore[no-untyped-def]
        self._modules, self._lock = modules, lock
        self._data = bytearray(65536)
        self._steps = self._total_us = self._longest_us = 0

    def answer(self, letter, now_us, data):  # type: ignore[no-untyped-def]
        """Do what a command says."""
        turns, now_us = now_us >> 30, now_us & TIME
        if letter == b"I":
            link_of, robot_of, settings_of = self._modules
            boot_id, cause, schema, *numbers = struct.unpack(SETTINGS, data)
            self._robot = robot_of.Robot(settings_of.Settings(*numbers))
            self._link = link_of.Link(self._robot, boot_id, cause, 0)
            self._link.frames.schema = struct.pack("<I", schema)
            return b""
        link, robot, size = self._link, self._robot, 0
        if letter == b"V":
            return view_of(link, robot)
        if letter == b"M":
            gc.collect()
            used = gc.mem_alloc() if hasattr(gc, "mem_alloc") else 0
            answer = struct.pack("<4I", used, self._steps, self._total_us, self._longest_us)
            self._steps = self._total_us = self._longest_us = 0
            return answer
        link.turns = turns
        travel = struct.unpack("<ii", data) if letter == b"S" else (0, 0)
        self._data[: len(data)] = data
        reason = data[0] if letter == b"E" else 0
        count = len(data)
        self._lock(True)
        if letter == b"R":
            link.receive(self._data, count, now_us)
            while robot.sum():
                pass
        elif letter == b"F":
            size = link.next_frame(now_us)
        elif letter == b"S":
            began_us = ticks_us()
            robot.step(now_us, travel[0], travel[1])
            took_us = ticks_us() - began_us & TIME
            self._steps += 1
            self._total_us += took_us
            self._longest_us = max(self._longest_us, took_us)
        elif letter == b"T":
            robot.tick(now_us)
        else:
            robot.emergency_stop(reason)
        self._lock(False)
        return bytes(link.frame[:size])


def view_of(link, robot):  # type: ignore[no-untyped-def]
    """What a test sees of the robot."""
    pose = robot.estimate.pose
    return struct.pack(
        VIEW,
        *robot.numbers,
        pose[0],
        pose[1],
        robot.left,
        robot.right,
        pose[2],
        link.count[4],
        link.session,
        robot.state,
        robot.reason,
        32 - robot.queue.count,
        robot.powered,
        robot.done,
        link.frames.expected,
        robot.follower.phase,
    )


def main():  # type: ignore[no-untyped-def]
    """Serve stdin, under MicroPython."""
    import micropython  # type: ignore[import-not-found]

    from clearway import link, robot, settings  # type: ignore[import-not-found]

    def lock(locked):  # type: ignore[no-untyped-def]
        if locked:
            micropython.heap_lock()
        else:
            micropython.heap_unlock()

    commands = Commands((link, robot, settings), lock)
    ask, say = sys.stdin.buffer, sys.stdout.buffer
    while True:
        head = ask.read(7)
        if not head or len(head) < 7:
            return
        now_us, count = struct.unpack("<IH", head[1:])
        answer = commands.answer(head[:1], now_us, ask.read(count) if count else b"")
        say.write(struct.pack("<H", len(answer)))
        say.write(answer)
        if hasattr(say, "flush"):
            say.flush()


if __name__ == "__main__":
    sys.path.insert(0, sys.argv[1])
    main()
