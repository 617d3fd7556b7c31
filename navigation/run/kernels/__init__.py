"""Kernels compiled before a run or for a wheel, in processes of their own."""
