"""The command line, one file a command.

``main.py`` finds the command, runs it and turns errors into exit codes. The commands are in folders
by their purpose: ``pictures`` looks at pictures and maps, ``setup`` prepares a machine and an
arena, ``calibrating`` calibrates a camera live, and ``running`` drives.

They share ``options.py`` (options and their checks), ``outputs.py``, ``progress.py``, ``voice.py``,
``cold_kernels.py`` and ``decoder_lines.py``. ``examples.py`` gives each command an example;
``reference.py`` and ``man_page.py`` make the documentation from the parser.
"""
