"""Orders of people to a running program: each exists once, in `table`.

From that table are made the commands of the command line, what the control socket takes (`control`)
and what the page offers and may order (`dashboard`). In the order of the data:

- `carry_out`: a request from outside, checked and given to the run's `People`; its answer.
- `table`: every order: its name, its arguments, who may give it, what it does, its help.
- `arguments`: how each argument is read.

Listing the table needs none of the program's libraries, so that `clearway --help` stays quick.
"""
