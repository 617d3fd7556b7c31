"""Plans for one robot or several, and how much of a plan each robot may drive.

- `traffic` names what the control loop needs of either.
- `alone`: the pilot's requests go to the planner, and the robot may drive all of its plan.
- `coordinated`: the coordinator promises each robot a part of its plan.
- `fleet_planner`: the newest roadmap and the promises for all, in a thread beside the loop.
"""
