"""The control loop of several robots: one camera and one planner, a pilot and a link for each.

`seat` is what one robot needs of it, the same parts as with one robot; `fleet_planner` answers for
all of them; `fleet_daemon` is the loop: newest frame -> eye -> every pilot -> coordinator -> orders
to the planner and every link. `fleet_state` is what it tells of itself after each cycle.
"""
