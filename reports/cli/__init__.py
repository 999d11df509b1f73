"""The command line `halfplane`: a command is a function of what it is about and of one frozen value
of options.

    application.py   the tables of options and of commands, and commands made of them; exit codes,
                     what is said of a fault, the one place that prints answers; streams and signals
    solving.py       run, exact, fe
    field_output.py  fields: files for ParaView, pictures
    results.py       score, diff
    scene_files.py   init, check, scenes, schema
    machine.py       doctor

The commands of many runs are in `reports.studies`, in commands.py of each folder; they take
`Answer` `Options` `WORKERS` `share_of`, the exit codes `EXIT_WITHIN` `EXIT_OUTSIDE`
`EXIT_NOT_CONVERGED` `EXIT_INTERRUPTED`, and of solving.py `Job` `solving_command` `read`
`deck_file`. The modules of commands are imported by name when one of their commands is called:
`halfplane --help` loads nothing heavy.
"""

from reports.cli.application import main

__all__ = ["main"]
