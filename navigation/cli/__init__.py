"""The command line, one file a command.

`main` finds the command, runs it and turns errors into exit codes. `pictures` looks at pictures and
maps, `setup` prepares a machine and an arena, `calibrating` calibrates a camera live, and `running`
drives.

`examples` gives each command an example; `reference` and `man_page` make the documentation from the
parser.
"""
