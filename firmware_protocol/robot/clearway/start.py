"""Access to the REPL: a button held at boot, and a moment for Ctrl-C.

A program in main.py takes the USB line or starts an unstoppable watchdog, and would lock its owner
out.
"""

import time

WINDOW_MS = 1500
"""Time for Ctrl-C at every start; ``mpremote`` and Thonny send it several times."""
STEP_MS = 50


def bootsel_held() -> bool:
    """True if BOOTSEL of an RP2040 or RP2350 is held (the 3pi+'s button B)."""
    from rp2 import bootsel_button  # type: ignore[import-not-found]

    return bool(bootsel_button())


def boot_pin_held() -> bool:
    """True if the button at GPIO0 is held: BOOT of an ESP32. Other boards use other pins."""
    from machine import Pin  # type: ignore[import-not-found]

    return not Pin(0, Pin.IN, Pin.PULL_UP).value()


def may_start(held, window_ms: int = WINDOW_MS) -> bool:  # type: ignore[no-untyped-def]
    """False if ``held()`` during the window.

    Ctrl-C in the window raises ``KeyboardInterrupt``, which leads to the REPL.
    """
    print("clearway: starts in", window_ms, "ms; hold the button or press Ctrl-C for the REPL")
    for _ in range(0, window_ms, STEP_MS):
        if held():
            print("clearway: the button is held: not started")
            return False
        time.sleep_ms(STEP_MS)  # type: ignore[attr-defined]
    return True
