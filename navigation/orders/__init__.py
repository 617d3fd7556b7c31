"""Orders of people to a running program: each exists once, in `table`.

The table defines the commands of the command line, the orders of the control socket (`control`) and
those of the page (`dashboard`). In the order of the data:

- `carry_out`: a request from outside, checked and given to the run's `People`; its answer.
- `table`: each order's name, arguments, permitted people, action and help.
- `arguments`: reads each argument.
- `errors`: orders that cannot be given or taken.

Listing the table needs none of the program's libraries, so that `clearway --help` stays quick.
"""
