"""The search for a plan: one robot after the other, all at once, and proofs of refusals.

- ``team.py`` defines robots and routes; ``fleet_search.py`` runs the stages and checks the plan.
- ``solver.py`` plans one robot after the other, and shortens the result.
- ``joint_search.py`` moves all robots at once; ``pair_proof.py`` proves that two can never pass.
- ``one_by_one.py`` moves one robot at a time between ``stations.py``, as in ``pebbles.py``.
- ``matching.py`` assigns rows to columns.
"""
