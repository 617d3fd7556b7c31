"""Parts that the kernels of vision share.

- `array_pool`: memory used for one picture after another.
- `typed_numbers`: numbers and answers with the types that kernels take.
"""
