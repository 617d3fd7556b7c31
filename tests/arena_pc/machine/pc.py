"""An arena PC: QEMU with two disks, an agent that runs commands, and a USB controller.

The processor is emulated in software, so that the machine is the same wherever it runs; it can do
what the wheel's kernels are compiled for. QEMU is spoken to by QMP, one JSON line each way.
Times are in seconds of the host.
"""

from __future__ import annotations

import base64
import itertools
import shlex
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from tests.arena_pc.machine.json_lines import GoneError, JsonLines

EMULATOR = "qemu-system-x86_64"
KERNEL_OPTIONS = (
    "console=ttyS0 quiet panic=-1 mitigations=off tsc=reliable audit=0 "
    "systemd.show_status=0 random.trust_cpu=on"
)
QMP_WITHIN_S = 60.0
AGENT_TAKES_S = 60.0
"""How much longer than a command its answer may take: a busy host."""


@dataclass(frozen=True, slots=True)
class Answer:
    """What a command in the guest printed, and its exit code (124: it took too long)."""

    code: int
    output: str


def machine(image: Path) -> list[str]:
    """The emulator's command line, as far as a snapshot depends on it."""
    disks = (f"file={image / name}.ext4,format=raw,if=virtio,readonly=on" for name in DISKS)
    return [
        *(EMULATOR, "-accel", "tcg,thread=multi", "-cpu", "max", "-smp", "2", "-m", "2048"),
        *("-M", "q35", "-nodefaults", "-no-user-config", "-display", "none", "-no-reboot"),
        *("-kernel", str(image / "vmlinuz"), "-initrd", str(image / "initrd.gz")),
        *("-append", KERNEL_OPTIONS),
        *(part for disk in disks for part in ("-drive", disk)),
        *("-device", "virtio-serial-pci", "-device", "virtio-rng-pci"),
        *("-device", "virtserialport,chardev=agent,name=agent"),
        *("-device", "qemu-xhci,id=usb,p2=8,p3=8"),
    ]


DISKS = ("system", "program")


class ArenaPC:
    """A machine that is switched on, with its sockets and logs in the folder ``work``.

    The path of ``work`` must be short: a Unix socket's name has at most 107 characters.
    """

    def __init__(self, image: Path, work: Path, options: Sequence[str] = ()) -> None:
        self.work = work
        self._ids = itertools.count(1)
        self._emulator_says = (work / "qemu.log").open("w", encoding="utf-8")
        command = [
            *machine(image),
            *("-chardev", f"socket,id=agent,path={work / 'agent'},server=on,wait=off"),
            *("-qmp", f"unix:{work / 'qmp'},server=on,wait=off"),
            *("-serial", f"file:{work / 'console.log'}"),
            *options,
        ]
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=self._emulator_says,
            stderr=subprocess.STDOUT,
        )
        try:
            self._qmp = JsonLines(work / "qmp", QMP_WITHIN_S)
            self._qmp.receive(QMP_WITHIN_S)  # its greeting
            self.qmp("qmp_capabilities")
            self._agent = JsonLines(work / "agent", QMP_WITHIN_S)
        except (GoneError, TimeoutError) as error:
            self._process.kill()
            self._process.wait()
            raise GoneError(f"{EMULATOR} does not start: {self.logs()}") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.switch_off()

    def switch_off(self) -> None:
        """End the emulator at once."""
        self._process.kill()
        self._process.wait()
        for line in (self._qmp, self._agent):
            line.close()
        self._emulator_says.close()

    def wait_for_agent(self, within_s: float) -> None:
        """Wait until a machine that boots takes commands."""
        said = self._agent.receive(within_s)
        if said != {"ready": True}:
            raise GoneError(f"the agent said {said}")

    def run(self, command: str, within_s: float = 60.0) -> Answer:
        """Run a shell command as root."""
        number = next(self._ids)
        self._agent.send({"id": number, "run": command, "within_s": within_s})
        said = self._agent.receive(within_s + AGENT_TAKES_S)
        if said.get("id") != number:
            raise GoneError(f"the agent answered {said}, not order {number}")
        return Answer(said["code"], said["output"])

    def check(self, command: str, within_s: float = 60.0) -> str:
        """What a command printed that has to succeed."""
        answer = self.run(command, within_s)
        assert answer.code == 0, f"{command}: exit code {answer.code}\n{answer.output}"
        return answer.output

    def write(self, file: str, text: str) -> None:
        """Write a file in the guest, for everybody to read."""
        data = base64.b64encode(text.encode()).decode()
        into = shlex.quote(file)
        self.check(f"mkdir -p $(dirname {into}) && echo {data} | base64 -d >{into}")

    def qmp(self, command: str, **arguments: Any) -> Any:
        """What QEMU returns to a command of its own."""
        self._qmp.send({"execute": command, "arguments": arguments})
        while True:
            said = self._qmp.receive(QMP_WITHIN_S)
            if "error" in said:
                raise GoneError(f"{command} {arguments}: {said['error']['desc']}")
            if "return" in said:  # all else is an event
                return said["return"]

    def logs(self) -> str:
        """The end of what the emulator and the guest's kernel said."""
        files = (self.work / "qemu.log", self.work / "console.log")
        texts = (file.read_text(errors="replace")[-2000:] for file in files if file.exists())
        return "\n".join(texts)
