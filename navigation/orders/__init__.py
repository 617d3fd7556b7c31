"""Orders of people to a running program: each exists once, in `table`.

- `carry_out`: a request from outside, checked and given to the run's `People`; its answer.
- `table`: each order's name, arguments, permitted people, action and help, for the command line,
  the control socket (`control`) and the page (`dashboard`).
- `arguments`: reads each argument.

The table imports no large library, so that `clearway --help` stays quick.
"""
