"""The recipe of Roque and Doering to the letter, for comparison with ours.

- `paper` runs sections 3.1 to 3.3.
- `corners` is its detector by the small eigenvalue of the covariance matrix (`corner_kernels`).
- `circles` is Sauer's test of digital circles (equation 14).
"""
