"""A robot through the Python interface, without the daemon: plan, upload, watch it drive.

    python examples/robot_without_daemon.py [FOLDER]

The robot is simulated on a pseudo-terminal; with a real one give its port to `SerialLink` instead.
What replaces the camera here is the simulated robot's own pose. Metres, radians, seconds.

The loop below is all that a control loop has to do for the robot: say at least twice a second that
it may still move (the lease), and tell it where it was seen. Stop doing so, and it stops.
"""

import math
import sys
import time
from pathlib import Path

import numpy as np

import navigation
import planner

ARENA = """\
#@ clearway.scene/1
#@ units m
#@ bounds given 0 0 2 1.5
C (1.0,0.7) 0.2
"""
START, GOAL = (0.3, 0.3), (1.7, 1.2)
LIMITS = planner.Limits(
    speed=0.4,
    acceleration=0.5,
    lateral_acceleration=0.5,
    angular_rate_rad_s=2.0,
    angular_acceleration_rad_s2=6.0,
    jerk=5.0,
    spacing=0.05,
    chord_tolerance=0.002,
    slow_clearance=0.2,
    slow_speed=0.15,
)
CYCLE_S = 0.05
PATIENCE_S = 60.0


def drive(robot: navigation.SimulatedRobot, waypoints: list) -> None:
    """Upload the waypoints and stay with the robot until it has executed them all."""
    with navigation.SerialLink(robot.port) as link:
        until_s = time.monotonic() + PATIENCE_S
        uploaded = False
        while time.monotonic() < until_s:
            link.pose_fix(*robot.pose(), captured_s=time.monotonic())
            link.lease(permit=True, pose_age_s=0.0)
            now = link.snapshot()
            if now.state.is_up and not uploaded:
                link.upload(1, waypoints)
                uploaded = True
            if uploaded and now.mission_id == 1:
                if now.mission_done:
                    return
                if now.standing_reason is not None:
                    link.start()  # this loop was held up, its lease ran out, and it may go on
            time.sleep(CYCLE_S)  # the rhythm of a control loop: a pose and a lease each time
        sys.exit(f"not done after {PATIENCE_S:g} s: {link.snapshot().standing_reason}")


def main(folder: Path) -> None:
    """Write driven.svg."""
    scene = planner.read_scene_text(ARENA)
    roadmap = planner.build_roadmap(scene, radius=0.12)
    path = roadmap.plan(START, GOAL)
    if isinstance(path, planner.NoPath):
        sys.exit(path.reason)
    trajectory = planner.time_path(path, LIMITS, clearance=roadmap.clearance)
    waypoints = navigation.to_wire(navigation.targets_of(path, trajectory))
    print(f"{len(waypoints)} waypoints, {trajectory.duration_s:.1f} s planned")

    with navigation.SimulatedRobot((*START, 0.0), rng=np.random.default_rng(1)) as robot:
        drive(robot, waypoints)
        x, y, _ = robot.pose()
        track = robot.track()[:, 1:3]
    off_mm = 1000 * math.dist((x, y), GOAL)
    print(f"arrived {off_mm:.1f} mm from the goal")
    print(f"the track kept {roadmap.path_clearance(track).distance:.3f} m from every obstacle")
    navigation.save_picture(
        folder / "driven.svg", scene, roadmap, path, trajectory=trajectory, track=track
    )


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
