"""The line itself: its pace, its clock, and its faults.

- `pace` times the bytes on the line; `send_window` keeps reliable frames until acknowledged.
- `sync_schedule` times questions for the robot's clock; `clock_sync` estimates it from the answers.
- `hearing` shows from the robot's counts that it hears what it is sent.
- `diagnosis` turns the state of a line without a link into a sentence.
"""
