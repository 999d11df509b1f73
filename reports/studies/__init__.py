"""Studies: what runs many scenes or another solver, above the core of `reports`, which never
imports them.

    sweep   a scene over axes of its keys, with a store and a page; processes or dask
    maps    errors of theory by kind of body: numbers, kernels, finite elements; advice on a scene
    paper   the paper's figures, statements and misprints again
    third   the scene as a deck for CalculiX, and CalculiX' answer

Each folder has its commands in commands.py. The command line and `halfplane run --third` find them
by name when they are asked for.
"""
