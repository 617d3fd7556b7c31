"""The line itself: its pace, its clock, and its faults.

- `pace` times the bytes on the line; `send_window` keeps reliable frames until acknowledged.
- `clock_sync` estimates the robot's clock.
- `hearing` shows from the robot's counts that it hears what it is sent.
- `diagnosis` turns the state of a line without a link into a sentence.
"""
