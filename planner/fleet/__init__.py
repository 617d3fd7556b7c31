"""Several robots on one roadmap: timed tracks, no two of which ever touch.

``ground`` lays the robots' shared graph over the roadmap; ``motions`` says exactly when moving
discs touch; ``search`` ends with a plan or a proof that there is none. ``dependencies`` orders the
robots at shared places, ``no_waiting`` keeps waits out of zones, ``execution`` releases waypoints.
``on_graph`` and ``on_roadmap`` are the interfaces, ``assignment`` distributes tasks, and
``schedule`` accepts goals at any time.
"""
