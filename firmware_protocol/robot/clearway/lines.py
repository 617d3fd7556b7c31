"""The serial line on a board: USB, which the REPL shares, or a UART."""

import select
import sys


class UsbLine:
    """USB serial. Ctrl-C is an ordinary byte; for the REPL, reset into safe mode."""

    def __init__(self) -> None:
        import micropython

        micropython.kbd_intr(-1)
        self._poll = select.poll()
        self._poll.register(sys.stdin, select.POLLIN)
        self._one = bytearray(1)
        self._in = sys.stdin.buffer
        self._out = sys.stdout.buffer

    def read(self, buffer: bytearray) -> int:
        """Read arrived bytes into the buffer; return their number."""
        count = 0
        while count < len(buffer) and self._has_more():
            self._in.readinto(self._one)  # type: ignore[union-attr]
            buffer[count] = self._one[0]
            count += 1
        return count

    def _has_more(self) -> bool:
        for _ in self._poll.ipoll(0):  # type: ignore[attr-defined]
            return True
        return False

    def can_write(self) -> bool:
        """True: USB takes a frame at once, or loses it if no host listens."""
        return True

    def write(self, view: memoryview) -> None:
        """Send a frame."""
        self._out.write(view)


class UartLine:
    """A ``machine.UART`` with a transmit buffer that holds a frame (``txbuf=256``)."""

    def __init__(self, uart) -> None:  # type: ignore[no-untyped-def]
        self._uart = uart

    def read(self, buffer: bytearray) -> int:
        """Read arrived bytes into the buffer; return their number."""
        if not self._uart.any():
            return 0
        return self._uart.readinto(buffer) or 0

    def can_write(self) -> bool:
        """True if the last frame has gone."""
        return bool(self._uart.txdone())

    def write(self, view: memoryview) -> None:
        """Send a frame."""
        self._uart.write(view)
