"""An example of every command, for its ``--help`` and the reference."""

from __future__ import annotations

from typing import NamedTuple

from navigation.orders.table import ORDERS


class Example(NamedTuple):
    """A command line and its effect."""

    line: str
    does: str


EXAMPLES: dict[str, Example] = {
    "demo": Example(
        "clearway demo --no-browser",
        "Run a simulated arena and print the dashboard's address.",
    ),
    "sample": Example("clearway sample arena", "Write arena.png, a picture of three obstacles."),
    "run": Example(
        "clearway run arena.yaml --once --report report.json",
        "Drive the configured mission, write the report, and end.",
    ),
    "extract": Example(
        "clearway extract arena.png --format json -o scene.json",
        "Find the obstacles in a picture and keep them as JSON.",
    ),
    "plan": Example(
        "clearway plan arena.png --start 40,40 --goal 600,400 --radius 9 --render plan.svg",
        "Plan through a picture for a robot of 9 pixels, and draw the plan.",
    ),
    "fleet": Example(
        "clearway fleet arena.scene --robots robots.csv --render fleet.svg",
        "Plan several robots at once, and draw them moving.",
    ),
    "roadmap": Example(
        "clearway roadmap map.yaml --radius 0.2 -o roadmap.geojson",
        "Turn a ROS map into a graph for Nav2's route server.",
    ),
    "audit": Example(
        "clearway audit depot.geojson --map depot.yaml --keepout keepout.yaml --radius 0.22"
        " --render audit.svg",
        "Measure every edge of a Nav2 graph, and draw what is wrong with it.",
    ),
    "markers": Example(
        "clearway markers arena.png --calibration calibration.yaml --render markers.png",
        "Find every marker in a picture, with its place on the floor, and draw them.",
    ),
    "robot": Example(
        "clearway robot --start 0.2,0.2,45 --faults drop=0.01",
        "Simulate a robot on a new pseudo-terminal that loses one byte in a hundred.",
    ),
    **{name: Example(*order.example) for name, order in ORDERS.items() if not order.command},
    "zone": Example(*ORDERS["zone_put"].example),
    "check": Example("clearway check arena.yaml", "Report every error with its line and column."),
    "calibrate": Example(
        "clearway calibrate --live /dev/video0 --squares 7x5 --square-mm 30"
        " --floor-picture floor.png -o calibration.yaml",
        "Calibrate lens with a printed board before the camera, and floor from a picture.",
    ),
    "reanchor": Example(*ORDERS["reanchor"].example),
    "marker": Example(
        "clearway marker 7 --size-mm 90 -o marker.pdf",
        "Write marker 7 as a page that prints at true size.",
    ),
    "devices": Example("clearway devices", "List the cameras and serial ports of this machine."),
    "camera": Example(
        "clearway camera 0 --write arena.yaml",
        "Judge the first camera, and put the settings that serve best into arena.yaml.",
    ),
    "doctor": Example(
        "clearway doctor arena.yaml --bundle report.zip",
        "Check machine, camera and port, and pack what a bug report needs.",
    ),
    "dashboard": Example(
        "clearway dashboard recordings/clearway_2026-03-04_05-06-07_001.mcap",
        "Look at a recorded run on the page: play, pause, jump.",
    ),
    "replay": Example(
        "clearway replay recordings/run.mcap --pose-mm 5",
        "Re-run vision and planning on a recording, and compare.",
    ),
    "sweep": Example(
        "clearway sweep arena.yaml --runs 100 --seed 1 -o sweep.csv",
        "Drive a simulated configuration a hundred times with varied errors.",
    ),
    "install-service": Example(
        "clearway install-service arena.yaml --print",
        "Print the systemd unit and the udev rule without writing them.",
    ),
    "init": Example("clearway init arena.yaml", "Write a commented configuration that runs."),
    "schema": Example(
        "clearway schema -o clearway.schema.json",
        "Write the JSON Schema, for completion and checks in an editor.",
    ),
    "completion": Example(
        "clearway completion bash",
        "Print the script that completes commands and options in bash.",
    ),
}


def epilog(command: str) -> str:
    """The example as the end of the command's help, unwrapped to be copied."""
    return epilog_of(EXAMPLES[command])


def epilog_of(example: Example) -> str:
    """The same of an example."""
    return f"\b\nExample: {example.does}\n  {example.line}"
