"""The service that `clearway install-service` writes, under systemd: started, watched, stopped.

No robot drives here: the adapter's line is silent, and the run waits for the robot's first word.
"""

from __future__ import annotations

from tests.arena_pc import arena
from tests.arena_pc.machine.pc import ArenaPC
from tests.arena_pc.machine.pictures import RAW_IS_SLOW, moving_disc
from tests.arena_pc.machine.programs import wait_for
from tests.arena_pc.machine.snapshot import BOOTED, State
from tests.arena_pc.machine.usb_sockets import ADAPTER, CAMERA, UsbSockets

STATE = State(
    "service",
    (
        f"clearway install-service {arena.FILE}",
        "systemctl daemon-reload",
        "systemctl start clearway",  # returns when the service says that it is ready
    ),
    arena.files(),
    BOOTED,
)
"""Nothing is plugged in yet: the service waits for camera and robot."""
STOPS_WITHIN_S = 10.0
"""Of the guest's clock: then systemd would kill it."""
OPEN_FILES = "ls -l /proc/$(systemctl show clearway --value -p MainPID)/fd"
PROCESSES = "pgrep -f 'opt/[c]learway'"
NAMES = f"realpath {CAMERA.format('C1')} {ADAPTER.format('A1')}"


def property_of(pc: ArenaPC, name: str) -> str:
    return pc.check(f"systemctl show clearway --value -p {name}").strip()


def stop(pc: ArenaPC) -> None:
    """Stop it, which has to be in order and in time, and leave no process behind."""
    seconds = pc.check("TIMEFORMAT=%R; { time systemctl stop clearway; } 2>&1", 180)
    assert float(seconds) < STOPS_WITHIN_S
    assert property_of(pc, "Result") == "success"
    assert property_of(pc, "ExecMainStatus") == "0"
    assert pc.run(PROCESSES).output == "", "a process of the service runs on"


def test_camera_and_adapter_are_found_again_under_other_names(pc: ArenaPC, usb: UsbSockets) -> None:
    camera = usb.camera(moving_disc, RAW_IS_SLOW)
    adapter = usb.adapter("A1")
    wait_for(pc, OPEN_FILES, r"(?s)(?=.*/dev/video0)(?=.*/dev/ttyUSB0)")

    # other programs still have the old ones, so that their names are not free
    for node in ("video0", "video1", "ttyUSB0"):
        pc.check(f"(sleep 3600 <>/dev/{node} >/dev/null 2>&1 &)")
    camera.unplug()
    usb.unplug_adapter(adapter)
    wait_for(pc, f"{NAMES} 2>&1; ls /dev/serial /dev/v4l 2>&1", r"(?s)(cannot.*){2}")
    camera = usb.camera(moving_disc, RAW_IS_SLOW)
    usb.adapter("A1")
    wait_for(pc, NAMES, r"/dev/video2\s/dev/ttyUSB1")
    wait_for(pc, OPEN_FILES, r"(?s)(?=.*/dev/video2)(?=.*/dev/ttyUSB1)")
    assert camera.sent > 0
    stop(pc)


def test_it_keeps_the_watchdog_and_is_restarted_when_it_hangs(pc: ArenaPC) -> None:
    assert property_of(pc, "ActiveState") == "active"
    first = property_of(pc, "WatchdogTimestampMonotonic")
    wait_for(pc, "systemctl show clearway --value -p WatchdogTimestampMonotonic", f"^(?!{first})")
    pc.check("kill -STOP $(systemctl show clearway --value -p MainPID)")
    wait_for(pc, "journalctl -u clearway -o cat", r"Watchdog timeout \(limit 40s\)!")
    wait_for(pc, "systemctl show clearway --value -p NRestarts", "^1")


def test_it_ends_at_once_while_its_kernels_compile(pc: ArenaPC) -> None:
    """Those in the wheel are for another processor then."""
    stop(pc)
    pc.write(
        "/etc/systemd/system/clearway.service.d/processor.conf",
        "[Service]\nEnvironment=NUMBA_CPU_NAME=generic\n",
    )
    pc.check("systemctl daemon-reload && systemctl start --no-block clearway")
    wait_for(pc, PROCESSES, r"\d+\n\d+")
    stop(pc)
