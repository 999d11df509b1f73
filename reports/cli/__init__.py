"""The command line `halfplane`: a command is a function of what it is about and of one frozen value of options.

    application.py   the table of commands, the start of the process, exit codes, what is said of a fault
    process.py       the streams and signals of the process
    options.py       options that commands share, and the command line that repeats a run
    solving.py       run, exact, fe, export, paper
    field_output.py  fields: files for ParaView, pictures, a film
    results.py       score, diff, advise
    findings.py      what `diff` compares: the values of a run or of a baseline
    studies.py       sweep, sweep status, sweep report, map
    scene_files.py   init, check, scenes, schema
    machine.py       doctor, completion

The modules of commands are imported when one of their commands is called: `halfplane --help` loads nothing heavy.
"""

from reports.cli.application import main

__all__ = ["main"]
