"""Vision in the control loop: frames in, poses and scene out, and the doubts about both.

- `vision_stage` dates each frame, runs the eye on it, and makes the eye again if it fails.
- `eye` finds the robots' poses and, where the arena changed, the new scene; `eye_settings` makes
  its settings; `joined/` is the eye of several cameras.
- `other_robots` remembers where the other robots were seen.
- `scene_doubt` holds the robot while the arena seen does not fit the arena known.
- `arena_view` keeps the newest picture and scene, and their doubts.
"""
