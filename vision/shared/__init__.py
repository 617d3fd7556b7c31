"""What the kernels of vision share: how they are compiled, and scratch memory."""
