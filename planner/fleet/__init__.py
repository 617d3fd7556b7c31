"""Several robots on one roadmap: timed tracks, no two of which ever touch.

``ground`` lays the graph that the robots share over the roadmap. ``motions`` holds what is exact:
when two moving discs touch, and one robot's earliest arrival among moving discs. ``search`` plans
one robot after the other and shortens the whole; where that finds nothing, it moves all at once, or
one at a time, and ends with a plan or a proof that there is none. ``fleet_plan`` is the answer,
which is checked before it is given out, ``dependencies`` says who passes before whom, and
``execution`` which waypoints may be sent. ``on_graph`` and ``on_roadmap`` are the doors,
``assignment`` chooses who goes where, and ``schedule`` takes goals at any time (``retiming``).
"""
