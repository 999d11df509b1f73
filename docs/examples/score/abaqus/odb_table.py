"""The contact tractions of an Abaqus .odb as a table that `halfplane score` reads.

    abaqus python odb_table.py JOB.odb TABLE.csv [PAIR]

Not tested in Abaqus, which the authors do not have: a test runs it on a stand-in for `odbAccess`. One row for each frame and node
of the slave surface: step, frame, total time, undeformed x and y, CPRESS, CSHEAR1, CSLIP1 where it was requested. PAIR is part of
the name of a contact pair, where there are several. Runs in Python 2.7, which older releases have, and in Python 3.
"""

# ruff: noqa: C402, RUF005, SIM118, UP010, UP031 (words of Python 2.7, and of Abaqus' repositories)
from __future__ import print_function

import csv
import sys

NAMES = ("CPRESS", "CSHEAR1", "CSLIP1")


def fields(frame, pair):
    """Quantity -> {(instance, node): value} of a frame; ValueError where several pairs answer."""
    found = {}
    for key in frame.fieldOutputs.keys():
        name, where = (key.split(None, 1) + [""])[:2]
        if name not in NAMES or pair.lower() not in where.lower():
            continue
        if name in found:
            raise ValueError("several contact pairs have %s: name one of them, such as %r" % (name, where))
        values = frame.fieldOutputs[key].values
        found[name] = dict(((value.instance.name, value.nodeLabel), float(value.data)) for value in values)
    return found


def rows(odb, pair):
    """One list for each frame and node."""
    places = {}
    for name, instance in odb.rootAssembly.instances.items():
        for node in instance.nodes:
            places[name, node.label] = node.coordinates
    number = 0
    for step in odb.steps.values():
        for frame in step.frames:
            number += 1
            found = fields(frame, pair)
            for node in sorted(found.get("CPRESS", {})):
                x, y = places[node][:2]
                tractions = [found[name].get(node, 0.0) if name in found else "" for name in NAMES]
                yield [number, step.totalTime + frame.frameValue, float(x), float(y)] + tractions


def main(source, target, pair=""):
    """Writes the table; a column that no frame has is left out."""
    from odbAccess import openOdb

    odb = openOdb(source, readOnly=True)
    table = list(rows(odb, pair))
    odb.close()
    if not table:
        raise ValueError("%s holds no CPRESS at nodes: request CSTRESS (and CDISP for the slip) on the contact pair" % source)
    heads = ["Frame", "Total time", "COORD1", "COORD2"] + list(NAMES)
    kept = [k for k in range(len(heads)) if all(row[k] != "" for row in table)]
    with open(target, "w") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow([heads[k] for k in kept])
        writer.writerows([[row[k] for k in kept] for row in table])
    print("%s: %d rows of %d columns" % (target, len(table), len(kept)))


if __name__ == "__main__":
    main(*sys.argv[1:])
