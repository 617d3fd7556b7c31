"""The control loop: what is seen, planned and sent, once a cycle."""
