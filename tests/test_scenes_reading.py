"""Scene files and what lies beside them: what is read, and each fault refused in one sentence with
file, key, value and rule.
"""

from __future__ import annotations

import json
import re
import tomllib
import tracemalloc
from collections.abc import Callable, Sequence
from functools import reduce
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refusals import refused_for, require_facts
from reports.measured import read_as_by_key
from reports.studies.sweep.study import load_study, points_of_study, study_of
from scenes import (
    Block,
    Bodies,
    HalfPlane,
    InputError,
    Pad,
    Scene,
    TimeSeriesLoad,
    load_scene,
    scene_names,
    scene_schema,
    scene_text,
)
from scenes.text_tables import text_table

DOCS = Path(__file__).parents[1] / "docs"
HERTZ = 'kind = "hertz"\nradius = 2.0'
PLAIN = f"""
[material]
young_modulus = 1
poisson_ratio = 0.3

[profile]
{HERTZ}

[friction]
coefficient = 0.5

[load]
kind = "polygon"
initial_loading = [[2.0, 0.0]]
cycle = [[2.0, 0.5], [2.0, -0.5]]
"""
POLYGON = PLAIN[PLAIN.index('kind = "polygon"') :]
PAPER = scene_text("hertz-paper").split("[[expected]]")[0]
BLOCK = '{kind = "block", width = 20.0, height = 3.0}'
PAD = '{kind = "pad", width = 8.0, height = 5.0}'
WIDE = '{kind = "pad", width = 28.0, height = 5.0}'


def bodies(**shapes: str) -> tuple[str, str]:
    """Old and new text of a scene with these bodies."""
    return (
        "[friction]",
        "[bodies]\n"
        + "".join(f"{name} = {shape}\n" for name, shape in shapes.items())
        + "[friction]",
    )


def number(keys: str) -> tuple[str, str]:
    """Old and new text of a scene with an expected number."""
    return "[material]", f"expected = [{{value = 1.0, {keys}}}]\n[material]"


def with_flat(width: float) -> tuple[str, str]:
    """Old and new text of a scene with a pad of this width, whose arcs of radius 10 begin at a flat
    from -2 to 2.
    """
    pad = f'{{kind = "pad", width = {width}, height = 12.0}}'
    rounded = 'kind = "flat_rounded"\nradius = 10.0\nflat_half_length = 2.0'
    return f"{HERTZ}\n\n[friction]", f"{rounded}\n[bodies]\nupper = {pad}\n[friction]"


CYCLE = "[[2.0, 0.5], [2.0, -0.5]]"
FIT = 'kind = "tabulated"\npoints = [[0, 0], [1, 1], [2, 4]]\nfit = {kind = '
# old text, new text, what the sentence must name
REFUSED = {
    "friction below zero": (
        "coefficient = 0.5",
        "coefficient = -0.1",
        "friction.coefficient = -0.1|greater than or equal to 0",
    ),
    "friction as text": (
        "coefficient = 0.5",
        'coefficient = "0.5"',
        "friction.coefficient = '0.5'|valid number; write it without quotation marks and unit",
    ),
    "a number with its unit": (
        "radius = 2.0",
        'radius = "1.5e3 mm"',
        "profile.radius = '1.5e3 mm'|valid number; write it without quotation marks and unit",
    ),
    "friction as date": (
        "coefficient = 0.5",
        "coefficient = 2020-01-01",
        "friction.coefficient = '2020-01-01'|valid number",
    ),
    "friction not a number": (
        "coefficient = 0.5",
        "coefficient = nan",
        "friction.coefficient = nan|finite",
    ),
    "a load without a square": (
        "mean_normal_load = 90.62286500739786",
        "mean_normal_load = 9e200",
        "load.mean_normal_load|9e+200 is above 1e+100",
    ),
    "nu at its upper end": (
        "poisson_ratio = 0.3",
        "poisson_ratio = 0.5",
        "material.poisson_ratio = 0.5|less than 0.5",
    ),
    "nu at its lower end": (
        "poisson_ratio = 0.3",
        "poisson_ratio = -1",
        "material.poisson_ratio = -1|greater than -1",
    ),
    "E zero": (
        "young_modulus = 1",
        "young_modulus = 0",
        "material.young_modulus = 0|greater than 0",
    ),
    "radius negative": ("radius = 2.0", "radius = -2.0", "profile.radius = -2.0|greater than 0"),
    "unknown key": (
        "coefficient = 0.5",
        "coefficient = 0.5\ncolour = 3",
        "unknown key friction.colour = 3|halfplane schema",
    ),
    "unknown table": (
        "[friction]",
        "[paint]\ncolour = 3\n[friction]",
        "unknown key paint|halfplane schema",
    ),
    "misspelt key": (
        "coefficient",
        "coeficient",
        "friction.coeficient|did you mean coefficient?|(also at fault: ",
    ),
    "missing key": (
        "coefficient = 0.5",
        "",
        "the key friction.coefficient is missing|halfplane schema",
    ),
    "missing kind": ('kind = "hertz"', "", "the key profile.kind is missing"),
    "unknown kind": (
        'kind = "hertz"',
        'kind = "hurtz"',
        "profile.kind = 'hurtz'|'hertz' or 'flat_rounded'",
    ),
    "no point": (
        "initial_loading = [[2.0, 0.0]]",
        "initial_loading = []",
        "load.initial_loading = []|at least 1 item",
    ),
    "a point of words": ("[2.0, 0.5]", '[2.0, "x"]', "load.cycle.0.1 = 'x'|valid number"),
    "a point twice": (
        "[2.0, 0.5]",
        "[2.0, 0.0]",
        "load is refused|[2.0, 0.0] stands twice in a row",
    ),
    "material a number": (
        "[material]\nyoung_modulus = 1\npoisson_ratio = 0.3",
        "material = 3",
        "material = 3|a table of keys",
    ),
    "two faults": (
        HERTZ + "\n\n[friction]\ncoefficient = 0.5",
        'kind = "hertz"\nradius = -1\n[friction]\ncoefficient = -1',
        "profile.radius = -1|(also at fault: friction.coefficient)",
    ),
    "a pad wider than its block": (
        *bodies(upper=WIDE, lower=BLOCK),
        "bodies is refused|upper body|width 28|wider than the block|width 20",
    ),
    "a pad past its arcs": (
        *bodies(upper='{kind = "pad", width = 4.0, height = 9.0}'),
        "bodies.upper.width = 4|past the end of the pad's arcs, at 4",
    ),
    "two pads": (
        *bodies(lower=PAD, upper=PAD),
        "bodies is refused|a pad on a pad|half_plane, a block or a t_shape",
    ),
    "a pad on a cylinder": (
        *bodies(
            lower='{kind = "cylinder", radius = 2.0}',
            upper='{kind = "pad", width = 1.0, height = 5.0}',
        ),
        "a pad on a cylinder|half_plane, a block or a t_shape",
    ),
    "a shouldered pad on a pad": (
        *bodies(
            lower=PAD,
            upper='{kind = "shouldered_pad", width = 1.0, shoulder_depth = 1.0, shoulder_width ='
            " 3.0, height = 5.0}",
        ),
        "bodies is refused|a shouldered_pad on a pad|a half_plane, a block or a",
    ),
    "a T-shape without a flange": (
        *bodies(
            upper='{kind = "t_shape", width = 6.0, flange_height = 2.0, stem_width = 6.0, height'
            " = 5.0}"
        ),
        "stem_width = 6|less than width = 6",
    ),
    "a T-shape without a stem": (
        *bodies(
            upper='{kind = "t_shape", width = 6.0, flange_height = 5.0, stem_width = 3.0, height'
            " = 5.0}"
        ),
        "flange_height = 5|less than height = 5",
    ),
    "a shoulder narrower than its pad": (
        *bodies(
            upper='{kind = "shouldered_pad", width = 4.0, shoulder_depth = 1.0, shoulder_width ='
            " 3.0, height = 5.0}"
        ),
        "shoulder_width = 3|more than width = 4",
    ),
    "a shoulder below its base": (
        *bodies(
            upper='{kind = "shouldered_pad", width = 1.0, shoulder_depth = 6.0, shoulder_width ='
            " 3.0, height = 5.0}"
        ),
        "shoulder_depth = 6|less than height = 5",
    ),
    "cylinders of another radius": (
        *bodies(
            lower='{kind = "cylinder", radius = 25.0}', upper='{kind = "cylinder", radius = 75.0}'
        ),
        "not that of the cylinders|radius = 18.75",
    ),
    "a cylinder of another radius": (
        *bodies(upper='{kind = "cylinder", radius = 50.0}'),
        "not that of the cylinders|radius = 50",
    ),
    "a cylinder in a hollow, by a negative radius": (
        *bodies(
            lower='{kind = "cylinder", radius = -100.0}', upper='{kind = "cylinder", radius = 50.0}'
        ),
        "bodies.lower.radius|a hollow face is no body here|1/R = 1/R1 - 1/R2",
    ),
    "a cylinder in a hollow, by the relative radius": (
        *bodies(
            lower='{kind = "cylinder", radius = 0.9}', upper='{kind = "cylinder", radius = 0.9}'
        ),
        "not that of the cylinders|a hollow face is no body here",
    ),
    "no width": (
        *bodies(upper='{kind = "pad", width = 0.0, height = 5.0}'),
        "bodies.upper.width = 0.0",
    ),
    "base": (
        *bodies(lower=BLOCK.replace("}", ', base = "glued"}')),
        "base = 'glued'|'fixed' or 'rollers'",
    ),
    "no kind of body": (
        *bodies(lower="{width = 8.0, height = 5.0}"),
        "the key bodies.lower.kind is missing",
    ),
    "unknown place": (*bodies(middle=BLOCK), "unknown key bodies.middle"),
    "power law": (
        HERTZ,
        'kind = "power_law"\nexponent = 0.9\nlength = 1.0\nrise = 1.0',
        "profile.exponent = 0.9|or equal to 1",
    ),
    "wedge": (HERTZ, 'kind = "wedge"\ntip_radius = 1.0', "profile.tip_half_length is missing"),
    "polynomial that falls": (
        HERTZ,
        'kind = "polynomial"\nlength = 1.0\nrises = [0.5, -1.0]',
        "falls at x = ",
    ),
    "function in a file": (
        HERTZ,
        'kind = "callable"\nextent = 1.0\nheight_function = "x*x"',
        "only be built in Python",
    ),
    "unknown tag": ("[material]", 'tags = ["papier"]\n[material]', "tags.0 = 'papier'"),
    "unknown quantity": (
        *number('quantity = "work", tolerance = 0.1, source = "x"'),
        "expected.0.quantity = 'work'",
    ),
    "number without source": (
        *number('quantity = "dissipation", tolerance = 0.1'),
        "expected.0.source is missing",
    ),
    "number of no engine": (
        *number('quantity = "dissipation", tolerance = 1, source = "x", engine = "x"'),
        "0.engine = 'x'",
    ),
    "phase": ("phase_degrees", "phase", "did you mean phase_degrees?"),  # it was "base"
    "unit in a key": ("radius = 1000", "radius_mm = 1000", "did you mean radius?"),
    "units that do not fit": ("title", 'units = "N, mm, GPa"\ntitle', "N/mm^2 is MPa, not GPa"),
    "units in another order": (
        "title",
        'units = "mm, N, MPa"\ntitle',
        "force, length and stress in this order",
    ),
    "units without commas": ("title", 'units = "N mm MPa"\ntitle', "with commas between"),
    "three numbers for two": (
        CYCLE,
        "[[9, 2, 3]]",
        "load.cycle.0 = [9, 2, 3]|at most 2",
    ),
    "a pad past its arcs beside a flat": (
        *with_flat(24.0),
        "past the end of the pad's arcs, at 24",
    ),
    "friction that is no table": (
        "[friction]\ncoefficient = 0.5",
        "[[friction]]",
        "friction is refused",
    ),
    "a kind of curve": (HERTZ, f'{FIT}"herz"}}', "profile.fit.kind = 'herz' is refused"),
    "noise below zero": (
        HERTZ,
        f'{FIT}"hertz", noise = -1.0}}',
        "profile.fit.noise = -1.0|greater than 0",
    ),
}
# What no scene can state is answered by the limit; it was "did you mean" something unrelated, as
# title for tilt.
NEGLECTED = {
    "wear": "wear is not modelled",
    "wear_coefficient": "wear is not modelled",
    "plasticity": "linear elastic, without plasticity",
    "yield_stress": "linear elastic, without plasticity",
    "temperature": "temperature is not modelled",
    "static_coefficient": "friction has one coefficient",
    "density": "quasi-static",
    "thickness": "per unit thickness",
}
TO_THE_LOAD = ("bulk", "bulk_stress", "remote_stress", "moments", "tilt_degrees", "eccentricity")
SAID = {key: f"|{said}|docs/theory.md, 'What is neglected'" for key, said in NEGLECTED.items()}
REFUSED |= {
    f"{key} in {place}": (
        f"[{place}]",
        f"[{place}]\n{key} = 0.5",
        f"unknown key {place}.{key} = 0.5; {said}",
    )
    for place in ("load", "friction", "profile")
    for key, said in (SAID | dict.fromkeys(TO_THE_LOAD, "bulk_stress_lower,")).items()
}
REFUSED |= {
    key: ("[material]", f"{key} = 0.5\n[material]", f"unknown key {key} = 0.5; {said}")
    for key, said in SAID.items()
}
NO_JSON = {"friction as date"}
# Text that is no TOML.
BROKEN = {
    "decimal comma": (
        "coefficient = 1.0",
        "coefficient = 1,0",
        "'coefficient = 1,0'|decimal point",
    ),
    "open quotes": ('kind = "ellipse"', 'kind = "ellipse', "in 'kind = \"ellipse"),
}


def refusal(path: Path | str, *facts: str) -> str:
    """The one sentence with which `path` is refused, which names each of `facts`."""
    with pytest.raises(InputError) as caught:
        load_scene(path)
    assert "\n" not in str(caught.value)
    require_facts(str(caught.value), *facts)
    return str(caught.value)


def edited(old: str, new: str) -> str:
    """The first of the two scenes that has the old text, with the new one in its place."""
    return next(text for text in (PLAIN, PAPER) if old in text).replace(old, new, 1)


@pytest.mark.parametrize("fault", [*REFUSED, *BROKEN])
def test_every_fault_is_one_sentence_naming_file_key_value_and_rule(
    fault: str, tmp_path: Path
) -> None:
    """And the same in JSON."""
    old, new, named = (REFUSED | BROKEN)[fault]
    (tmp_path / "mine.toml").write_text(edited(old, new), encoding="utf-8")
    refusals = {"mine.toml": refusal(tmp_path / "mine.toml")}
    if fault not in NO_JSON | BROKEN.keys():
        (tmp_path / "mine.json").write_text(
            json.dumps(tomllib.loads(edited(old, new))), encoding="utf-8"
        )
        refusals["mine.json"] = refusal(tmp_path / "mine.json")
    for name, sentence in refusals.items():
        assert sentence.startswith(f"{tmp_path / name}: ")
        require_facts(sentence, *named.split("|"))
        assert "What is neglected" not in sentence or "did you mean" not in sentence


FILES = {
    "empty.toml": ("", "is empty"),
    "blank.json": (" \n", "is empty"),
    "broken.toml": ("[material", "not valid TOML"),
    "broken.json": ('{"material": ', "not valid JSON"),
    "list.json": ("[1, 2]", "a table of keys, not a list"),
    "nothing.json": ("null", "a table of keys"),
    "scene.yaml": (PLAIN, "ends in .toml or .json, not in '.yaml'"),
    "scene.TOML": (PLAIN, "ends in .toml or .json, not in '.TOML'"),
    "deep.json": ("[" * 100_000, "not valid JSON"),
    "deep.toml": ("a = " + "[" * 100_000, "not valid TOML"),
    "long.json": ('{"cycles": ' + "1" * 5000 + "}", "not valid JSON"),
}


@pytest.mark.parametrize("name", FILES)
def test_files_that_hold_no_scene(name: str, tmp_path: Path) -> None:
    text, rule = FILES[name]
    (tmp_path / name).write_text(text, encoding="utf-8")
    assert refusal(tmp_path / name, rule).startswith(f"{tmp_path / name}: ")


def test_files_that_can_not_be_read_and_names_that_are_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "mine.toml"
    file.write_bytes(b"\xff\xfe\x00\x01")
    (tmp_path / "folder.toml").mkdir()
    for path, *facts in (
        (file, "not UTF-8"),
        (tmp_path / "folder.toml", "can't be read", "Is a directory"),
        (tmp_path, "is a folder"),
        (tmp_path / "nowhere" / "mine.toml", "can't be read", "No such file"),
        ("hertz-papr", "did you mean hertz-paper?"),
        ("zzz", *scene_names()),
    ):
        refusal(path, *facts)
    with refused_for("no such scene", "zzz"):
        scene_text("zzz")
    file.write_text(PLAIN, encoding="utf-8")
    with refused_for(str(file), "this is a scene"):
        load_study(file)

    def denied(*_: object, **__: object) -> None:  # root, who runs many CIs, may read everything
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_text", denied)
    assert refusal(file, "can't be read", "Permission denied").startswith(f"{file}: ")


def test_the_page_of_the_limits_is_there_and_an_axis_of_a_sweep_is_answered_by_it_too() -> None:
    assert "\n## What is neglected\n" in (DOCS / "theory.md").read_text(encoding="utf-8")
    axes = [{"name": "s", "key": "wear.rate", "values": [1.0, 2.0]}]
    with refused_for("no wear", "wear is not modelled"):
        points_of_study(study_of({"scene": "hertz-paper", "axes": axes}, "here"))


# ---------------------------------------------------------------------------- tables beside a scene
SERIES = (POLYGON, 'kind = "time_series"\nfile = "table.csv"')
TRACE = (
    HERTZ,
    'kind = "tabulated"\nfile = "table.csv"',
)


def named(columns: str) -> tuple[str, str]:
    """The edit of the scene that has the table with these columns."""
    return SERIES[0], f"{SERIES[1]}\ncolumns = {{{columns}}}"


DECIMAL = "the decimal sign of this file is a"
TABLES = [
    (SERIES, "time,P,Q\n0,1,0\n1,nan,0\n", ", line 3: P = 'nan' is not a finite number"),
    (SERIES, "\ufefftime,P,Q\n0,1,0\n1,2,0\n1,3,0\n", ", line 4: time = 1 stands there twice"),
    (
        SERIES,
        "time,P,Q\n0,1,0\n2,2,0\n# late\n1,3,0\n",
        ", line 5: time = 1 comes after a later one",
    ),
    (SERIES, "time,P,Q\n0,1\n", ", line 2: 3 numbers (time, P, Q) are needed"),
    (
        SERIES,
        "t,N,Q\n0,1,2\n",
        ", line 1|'t,N,Q'|none is known as P|columns = {P = ...}",
    ),
    (
        SERIES,
        "0,1,2,3\n1,2,3,4\n",
        ", line 1|3 numbers (time, P, Q)|'0,1,2,3'|columns = {time = 1,",
    ),
    (
        SERIES,
        "time,FN,fn,Q\n0,1,1,2\n1,2,2,3\n",
        ", line 1|'FN', 'fn'|could each be P|columns = {P = ...}",
    ),
    (
        SERIES,
        "Rig 7\na,b,c\n0,1,2\n1,2,3\n",
        ", line 2|'a,b,c'|none is known as time or P or Q",
    ),
    (
        named("time = 1, P = 4, Q = 5"),
        "0,1,2,3\n1,2,3,4\n",
        ", line 1|no column 5|has 4",
    ),
    (
        named("P = 0"),
        "time,P,Q\n0,1,0\n1,2,0\n",
        "columns = {P = 0}|numbered from 1",
    ),
    (
        named("P = 2, Q = 2"),
        "time,P,Q\n0,1,0\n1,2,0\n",
        ", line 1|time, P, Q|different columns",
    ),
    (
        named('time = "Zeit", P = "FN", Q = "Quer"'),
        "Zeit [s];Kraft [N];Quer [N]\n0,0;1,5;0,5\n1,0;2,5;0,5\n",
        "'Zeit [s];Kraft [N];Quer [N]'|no heading is 'FN'|columns = {P = ...}",
    ),
    (
        SERIES,
        "time;P;Q\n0,0;5.000,5;2\n",
        f", line 2|P = '5.000,5'|{DECIMAL} comma",
    ),
    (SERIES, "time,P,Q\n0,1,0\n", ", line 2: one row is no history"),
    (SERIES, "time,P,Q\n0,0,1,5,-0,3\n", "commas between the columns"),
    (
        SERIES,
        "time;P;Q\n0;1,5;2\n1;1.234;2\n",
        f", line 3|P = '1.234'|{DECIMAL} comma",
    ),
    (SERIES, "time;P;Q\n0;1;2\n1;1_000;2\n", ", line 3: P = '1_000' is not a finite number"),
    (
        SERIES,
        "time,P [kN],Q\n0,1,0\n1,2,0\n",
        "P is in kN|per unit thickness|key thickness",
    ),
    (
        SERIES,
        "time,Friction force\n0,1\n1,2\n",
        "none is known as P|columns = {P = ...}|or constant_normal_load = 100.0",
    ),
    (SERIES, "P,Q\n0,1\n1,2\n", "none is known as time|or interval = 0.01"),
    (SERIES, "time,P,U\n0,1,0\n1,1,2\n", "none is known as Q|or tangential_displacement = true"),
    (
        SERIES,
        "time,P,Q\n1/2/2026 9:00:00,1,0\n2/2/2026 9:00:00,2,0\n",
        ", line 3: time = '2/2/2026 9:00:00'|day and month can't be told from each other",
    ),
    (SERIES, "time,P,Q\n9:00:00,1,0\nnoon,2,0\n9:00:01,2,0\n", ", line 3|nor a time such as"),
    (SERIES, "time,P,Q\n0,1,0\n1,,2\n", ", line 3: P = ''|fill it in, or take out the line"),
    (SERIES, "Tijd,A,B\ns,N,N\n0,1,0\n1,2,0\n", ", line 1|not 'Tijd,A,B'"),
    (SERIES, "time,P,Q\n0,1,0\n0.5,,\n1,2,0\n", ", line 3: 3 numbers (time, P, Q) are needed"),
    (TRACE, "", ": the file is empty"),
    (TRACE, None, ": the file can't be read: No such file"),
    (TRACE, "a,b\n0,0\n", ", line 1: the columns are x, h, not 'a,b'"),
    (TRACE, "x,h\n0,0\n1,oops\n2,3\n", ", line 3: h = 'oops' is not a finite number"),
    (TRACE, "0,0\n1,1\n\n2\n", ", line 4: 2 numbers (x, h) are needed, not '2'"),
    (TRACE, "x,h\n0,0\n2,1\n1,2\n", ", line 4: x = 1 does not ascend"),
    (TRACE, "x,h\n# a remark\n0,0\n1,2\n2,1\n", ", line 5: h = 1 falls: the profile must rise"),
    (TRACE, "x,h\n0,0\n1,0\n2,0\n", ", line 4: the profile is flat from end to end"),
    (TRACE, "x,h\n1,0\n2,1\n3,2\n", "a row with x = 0"),
    (TRACE, "x,h\n-2,4\n-1,1\n0,0\n1,1.5\n2,4\n", ", line 5: the profile is not symmetric"),
    (TRACE, "x,h\n-1,1\n0,0\n1,1\n2,4\n", ", line 5: x = 2 has no partner on the other side"),
    (
        (HERTZ, f'{TRACE[1]}\nfit = {{kind = "hertz"}}'),
        "x,h\n-1,1\n0,0\n1,1\n0.5,4\n",
        "table.csv, line 5: x = ",
    ),
    (
        (SERIES[0], f"{SERIES[1]}\nthickness = 2.0"),
        "time,P [kN/m],Q\n0,1,0\n1,2,0\n",
        "P is in kN/m|per length already|key thickness",
    ),
]


@pytest.mark.parametrize(("edit", "text", "words"), TABLES)
def test_faults_in_tables_name_file_line_and_rule(
    edit: tuple[str, str], text: str | None, words: str, tmp_path: Path
) -> None:
    if text is not None:
        (tmp_path / "table.csv").write_text(text, encoding="utf-8")
    (tmp_path / "mine.toml").write_text(PLAIN.replace(*edit), encoding="utf-8")
    refusal(tmp_path / "mine.toml", "table.csv", *words.split("|"))


# Text, keys of the table, rows that are found, words of the record.
SCENE_UNITS = {"units stated": "kN, mm, GPa", "words in other columns": "SI"}
FORMS = {
    "spreadsheet": (
        "\ufeffTime [s];Normal force [kN];FT [N]\r\n0;1,5;5\r\n1;1,6;6,5\r\n",
        "thickness = 10",
        [[0, 150, 0.5], [1, 160, 0.65]],
        ("semicolon", "comma", "times 1000", "over the thickness 10"),
    ),
    "data logger": (
        (
            "Rig 7\nDate\t1.2.2026\nt / ms\tFN (N/mm)\tFT (N/mm)\tnote\n0\t1\t2\tok\n500\t2\t3\tok,"
            " fine\n"
        ),
        "",
        [[0, 1, 2], [0.5, 2, 3]],
        ("tab", "2 skipped", "times 0.001"),
    ),
    "units below": (
        "time;P;Normalkraft\ns;kN;N\n0;1;0,5\n1;2;0,6\n",
        'thickness = 2\ncolumns = {Q = "Normalkraft"}',
        [[0, 500, 0.25], [1, 1000, 0.3]],
        ("kN", "over the thickness 2", "'Normalkraft', N (in the line of units)"),
    ),
    "units below, columns by number, blanks": (
        "time  load  shear\ns  kN  kN\n0  1  0.5\n1  2  0.6\n",
        "thickness = 2\ncolumns = {time = 1, P = 2, Q = 3}",
        [[0, 500, 250], [1, 1000, 300]],
        ("'load'", "'shear'", "kN (in the line of units)"),
    ),
    "numpy's headings": ("# time Q P\n0 1 2\n1 2 3\n", "", [[0, 2, 1], [1, 3, 2]], ("blanks",)),
    "decimal commas and blanks": (
        "Time  Normal force  Q\n0,0  1,5  2\n0,5  2,5  3\n",
        "",
        [[0, 1.5, 2], [0.5, 2.5, 3]],
        ("comma",),
    ),
    "words in other columns": (
        "state,time,P,Q\nn/a,0,1,2\n,1,2,3\n",
        "",
        [[0, 1, 2], [1, 2, 3]],
        ("'P'",),
    ),
    "quotes": ('"time","P","Q"\n"0","1","2"\n"1","2","3"\n', "", [[0, 1, 2], [1, 2, 3]], ("'P'",)),
    "comma at each end": ("time,P,Q,\n0,1,2,\n1,2,3,\n", "", [[0, 1, 2], [1, 2, 3]], ("'P'",)),
    "columns by heading": (
        "a;b;c\n0;1;2\n1;2;3\n",
        (
            'columns = {time = "a", P = "c", Q = "b"}\nzero = {P = 1}\nscale = {P = 3}\nsign = {Q'
            " = -1}"
        ),
        [[0, 3, -1], [1, 6, -2]],
        ("zero at 1 of the file, times 3 (scale)", "sign turned"),
    ),
    "columns by number": (
        "junk\n0;1;2;9\n1;2;3;9\n",
        "columns = {time = 1, P = 3, Q = 2}",
        [[0, 2, 1], [1, 3, 2]],
        ("column 3",),
    ),
    "units stated": (
        "0,1,2\n1,2,3\n",
        'units = {P = "N/mm", time = "min"}',
        [[0, 0.001, 2], [60, 0.002, 3]],
        ("N/mm (stated), times 0.001",),
    ),
    "test stand": (
        'Test;7\n"Zeit";"Normalkraft";"Reibkraft";"Weg"\n(s);(kN);(N);(µm)\n\n'
        "0,0;1,5;5,0;0\n0,5;1,6;6,5;0\nEnde;;;\nMax;1,6;6,5;0\n",
        "thickness = 10",
        [[0, 150, 0.5], [0.5, 160, 0.65]],
        ("2 lines behind the rows, from line 7 on: 'Ende;;;'", "not read: 'Weg'", "times 1000"),
    ),
    "times of day across midnight": (
        "Heure;Temps;Effort normal;Effort tangentiel\n"
        "1;23:59:59,25;1,5;0,5\n2;00:00:00,75;2,5;0,5\n",
        "",
        [[0, 1.5, 0.5], [1.5, 2.5, 0.5]],
        ("times of day: seconds since 23:59:59,25", "not read: 'Heure'"),
    ),
    "times of day with another decimal sign": (
        "Temps;Effort normal;Effort tangentiel\n12:00:00.25;1,5;0,5\n12:00:01.25;2,5;0,5\n",
        "",
        [[0, 1.5, 0.5], [1, 2.5, 0.5]],
        ("decimal sign: comma",),
    ),
    "dates": (
        "Timestamp,Forza normale,Forza tangenziale\n"
        "2026-11-29T23:59:59.5Z,1,2\n2026-11-30T00:00:01.0Z,2,3\n",
        "",
        [[0, 1, 2], [1.5, 2, 3]],
        ("times of day: seconds since 2026-11-29T23:59:59.5Z",),
    ),
    "a constant P and even rows": (
        "Fuerza tangencial (N);Desplazamiento (µm)\n5;0\n6;1\n",
        "thickness = 10\ninterval = 0.25\nconstant_normal_load = 90.0",
        [[0, 90, 0.5], [0.25, 90, 0.6]],
        ("no column: 0.25 from row to row", "no column: 90 in every row", "'Desplazamiento (µm)'"),
    ),
    "oscilloscope": (
        "Model,X9\nTIME,CH1,CH2,CH3,CH4\nSequence,Volt,Volt\n0,1,2\n1e-3,2,3,\n",
        'columns = {P = "CH1", Q = "CH2"}\nscale = {P = 20, Q = 10}',
        [[0, 20, 20], [1e-3, 40, 30]],
        ("times 20 (scale)", "not read: 'CH3', 'CH4'"),
    ),
    "units in a line that says so": (
        "LabVIEW Measurement\nDecimal_Separator\t,\nY_Unit_Label\tkN\tN\tµm\n"
        "X_Value\tNormalkraft\tReibkraft\tWeg\tComment\n0,0\t1,5\t5,0\t0\n0,5\t1,6\t6,5\t0\n",
        'thickness = 10\ncolumns = {time = "X_Value"}',
        [[0, 150, 0.5], [0.5, 160, 0.65]],
        ("kN (in the line of units), times 1000", "3 skipped"),
    ),
    "settings beside the rows": (
        "Record Length,3,,-1.0,5,Record Length,3,,-1.0,1\nVertical Units,V,,0.0,6,,,,0.0,2\n"
        ",,,1.0,7,,,,1.0,3\n",
        "columns = {time = 4, P = 5, Q = 10}\nscale = {P = 20, Q = 10}",
        [[-1, 100, 10], [0, 120, 20], [1, 140, 30]],
        ("'V' in the line of units", "times 20 (scale)"),
    ),
    "a line of text that other marks cut": (
        "Channels\tTime P Q\nExport: 29.11.2026 12:30:05\nTime [s];P;Q\n0;1;2\n1;2;3\n",
        "",
        [[0, 1, 2], [1, 2, 3]],
        ("semicolon", "2 skipped"),
    ),
    "headings once more": (
        "time,P,Q\n0,1,2\ntime,P,Q\n1,2,3\n",
        "",
        [[0, 1, 2], [1, 2, 3]],
        ("left out: line 3: the headings once more",),
    ),
    "volts": (
        "time,P [V],Q\n0,1,2\n1,2,3\n",
        "scale = {P = 20}",
        [[0, 20, 2], [1, 40, 3]],
        ("no unit that is known: taken as it stands",),
    ),
}


@pytest.mark.parametrize("form", FORMS)
def test_a_record_of_any_form_is_read_and_what_was_assumed_is_said(
    form: str, tmp_path: Path
) -> None:
    """And stays so when the scene is changed, saved, or sent as JSON; the keys that say how a file
    is read go with the file.
    """
    text, keys, rows, words = FORMS[form]
    units = SCENE_UNITS.get(form, "N, mm, MPa")
    (tmp_path / "table.csv").write_bytes(text.encode())
    (tmp_path / "mine.toml").write_text(
        f'units = "{units}"\n' + PLAIN.replace(SERIES[0], f"{SERIES[1]}\n{keys}"), encoding="utf-8"
    )
    scene = load_scene(tmp_path / "mine.toml")
    np.testing.assert_allclose(scene.load.rows.values, rows, rtol=1e-15)
    record = "; ".join(": ".join(pair) for pair in scene.load.read_as)
    assert all(word in record for word in words), record
    assert (
        Scene.model_validate_json(scene.model_dump_json())
        == scene.vary(friction=scene.friction.coefficient)
        == scene
    )
    scene.save(tmp_path / "saved.toml")
    reloaded = load_scene(tmp_path / "saved.toml").load
    assert (reloaded.rows, reloaded.read_as) == (scene.load.rows, scene.load.read_as)
    assert reloaded.file is reloaded.columns is reloaded.scale is None
    replaced = scene.vary(load={"rows": [[0, 1, 0], [1, 2, 0]]}).load
    assert (replaced.file, replaced.read_as, replaced.thickness, replaced.units) == (
        None,
        None,
        None,
        None,
    )


def test_reading_keys_without_a_file_and_units_that_came_later_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for key in ("thickness", "interval", "constant_normal_load"):
        with refused_for(key, "how a file is read", "`rows`", error=ValueError):
            TimeSeriesLoad(rows=[[0, 1, 0], [1, 2, 0]], **{key: 2.0})
    (tmp_path / "table.csv").write_text("time,P [kN/m],Q\n0,1,0\n1,2,0\n", encoding="utf-8")
    (tmp_path / "mine.toml").write_text(PLAIN.replace(*SERIES), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    scene = load_scene("mine.toml")
    with refused_for("load.file", "'N, mm, MPa'", "file and units together"):
        scene.vary(units="kN, mm, GPa")
    in_new_units = scene.vary(units="kN, mm, GPa", load={"file": "table.csv"})
    np.testing.assert_allclose(in_new_units.load.rows.values[:, 1], [1e-3, 2e-3])
    driven = {"approach": True, "tangential_displacement": True, "constant_normal_load": 2.0}
    with refused_for("approach stands in the place of P"):
        scene.vary(load=driven)
    for words in ("volts", "mm"):
        with refused_for("units.P", f"'{words}'", "no unit of force"):
            scene.vary(load={"units": {"P": words}})


def test_a_profile_has_the_same_keys(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text(
        "x [µm];z [nm]\n1000;20000,0\n1250;20500,0\n1500;22000,5\n", encoding="utf-8"
    )
    keys = "zero = {x = 1000, h = 20000}"
    (tmp_path / "mine.toml").write_text(
        PLAIN.replace(TRACE[0], f"{TRACE[1]}\n{keys}"), encoding="utf-8"
    )
    profile = load_scene(tmp_path / "mine.toml").profile
    np.testing.assert_allclose(
        profile.points.values, [[0, 0], [0.25, 5e-4], [0.5, 2.0005e-3]], rtol=1e-12
    )
    assert (
        dict(profile.read_as)["h"]
        == "'z [nm]', nm (in its heading), times 1e-06, zero at 20000 of the file"
    )


SPOILT = st.text("0123456789.,;\t -+eE\n#nan'\"", max_size=80)


@settings(max_examples=80)
@given(
    text=SPOILT,
    head=st.sampled_from(
        ["time,P,Q\n", "Time [s];FN [N/mm];FT [N/mm]\n", "time\tP\tQ\n", "", "\ufeff# time P Q\n"]
    ),
)
def test_whatever_stands_in_a_table_is_numbers_or_a_sentence(
    text: str, head: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "any.csv"
    path.write_text(head + text, encoding="utf-8")
    try:
        table = text_table(path, ("time", "P", "Q"))
    except InputError as fault:
        assert str(fault).startswith(str(path))  # noqa: PT017
    else:
        lines = (head + text).split("\n")
        assert np.all(np.abs(table.values) <= 1e100)
        assert table.values.shape == (len(table.line_numbers), 3)
        # each number stands on its line
        for row, line in zip(table.values.tolist(), table.line_numbers.tolist(), strict=True):
            cells = re.split(
                r"[;\t, ]+" if table.decimal_sign == "point" else r"[;\t ]+",
                lines[line - 1].split("#")[0].replace('"', " "),
            )
            numbers = [float(cell.replace(",", ".")) for cell in cells if cell]
            assert set(row) <= set(numbers)


@pytest.mark.parametrize(
    ("encoding", "name"),
    [
        ("utf-8", ""),
        ("utf-8-sig", ""),
        ("utf-16", "UTF-16"),
        ("utf-16-be", "UTF-16, without its mark"),
        ("cp1252", "Windows-1252"),
        ("cp932", "Shift-JIS"),
    ],
)
def test_tables_of_other_systems_are_read_and_what_they_are_written_in_is_said(
    encoding: str, name: str, tmp_path: Path
) -> None:
    remark = "試験片の番号" if encoding == "cp932" else "Kraft über Zeit"
    text = f"# {remark}\r\nZeit;P;Q\r\n0;1,5;0,5\r\n1;2,5;0,5\r\n"
    (tmp_path / "table.csv").write_bytes(text.encode(encoding))
    scene = PLAIN.replace(*SERIES).replace('"table.csv"', '"table.csv"\ncolumns = {time = "Zeit"}')
    (tmp_path / "mine.toml").write_text(scene, encoding="utf-8")
    load = load_scene(tmp_path / "mine.toml").load
    assert load.rows.values.tolist() == [[0, 1.5, 0.5], [1, 2.5, 0.5]]  # type: ignore[union-attr]
    characters = dict(load.read_as or ()).get("characters", "")  # type: ignore[union-attr]
    assert characters.startswith(name)
    assert bool(characters) == bool(name)
    (tmp_path / "table.csv").write_bytes(
        b"\xff\xfe\x00\xd8\x41\x00" if name.startswith("UTF-16") else b"time,P,Q\n\xff\x00,1\n"
    )
    refusal(tmp_path / "mine.toml", "can't be read", "not UTF-")


def test_two_million_rows_are_streamed(tmp_path: Path) -> None:
    """A tenth of them here: what is held beside the numbers is that of some ten thousand rows."""
    path = tmp_path / "long.csv"
    count = 200_000
    path.write_text(
        "time;P;Q\n" + "".join(f"{k};1,5;0,{k}\n" for k in range(count)), encoding="utf-8"
    )
    tracemalloc.start()
    table = text_table(path, ("time", "P", "Q"))
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert (len(table.values), table.line_numbers[-1]) == (count, count + 1)
    assert most < 2.2 * table.values.nbytes + 2 * table.line_numbers.nbytes + 16e6


def test_tables_lie_beside_the_scene_file_and_their_rows_go_with_the_scene(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With marks of byte order, remarks and empty lines, as spreadsheets and profilometers save
    them.
    """
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "table.csv").write_text(
        "# profilometer\nx, h\n0, 0\n1, 0.5\n\n2, 2.0\n", encoding="utf-8-sig"
    )
    text = PLAIN.replace(*TRACE).replace("table.csv", "deep/table.csv")
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8-sig")
    monkeypatch.chdir("/")
    scene = load_scene(tmp_path / "mine.toml")
    np.testing.assert_allclose(scene.profile.height([0.5, 1.5, 3.0]), [0.125, 1.125, 4.0])
    (tmp_path / "deep" / "table.csv").unlink()
    assert Scene.model_validate_json(scene.model_dump_json()).profile == scene.profile
    load = load_scene("time-series").load
    assert (load.file, len(load.rows)) == ("time-series.csv", 40)  # packaged beside its scene


# ------------------------------------------------------------------------------------- what is read
TWO = (
    "[material.upper]\nyoung_modulus = 3.0\npoisson_ratio = 0.1\n[material.lower]\nyoung_modulus ="
    " 1.0\npoisson_ratio = -0.2"
)
ALL = '\nname = "other"\ncycles = 2\ntolerances = {shear = 0.5}\n[material]'
WIDER = ("radius = 2.0", "radius = 50.0")
NARROW = BLOCK.replace("20.0", "8.0")
UNITS = (
    "N, mm, MPa",
    "N, m, Pa",
    "kN, mm, GPa",
    "lbf, in, psi",
    "kip, in, ksi",
    "SI",
    "N, furlong, Pa",
)
SMALL = '{kind = "cylinder", radius = 30.0}'
LARGE = '{kind = "cylinder", radius = 60.0}'
CYLINDERS = [{"lower": SMALL, "upper": LARGE}, {"lower": LARGE, "upper": SMALL}]
# Edits of the scene, what is asked of it, and the answer.
READ: dict[str, tuple[Sequence[tuple[str, str]], Callable[[Any], Any], Any]] = {
    "plain": (
        (),
        lambda s: (
            s.name,
            s.friction.coefficient,
            s.material.alike,
            s.load.cycle,
            s.material.lower.young_modulus,
        ),
        ("mine", 0.5, True, ((2.0, 0.5), (2.0, -0.5)), 1.0),
    ),
    "all options": (
        (("\n[material]", ALL),),
        lambda s: (s.name, s.cycles, s.tolerances.shear),
        ("other", 2, 0.5),
    ),
    "two materials": (
        (("[material]\nyoung_modulus = 1\npoisson_ratio = 0.3", TWO),),
        lambda s: (
            s.material.alike,
            s.material.upper.young_modulus,
            s.material.lower.poisson_ratio,
        ),
        (False, 3, -0.2),
    ),
    "half-planes where left out": (
        (),
        lambda s: s.bodies,
        Bodies(lower=HalfPlane(), upper=HalfPlane()),
    ),
    "a block on rollers and a pad": (
        (
            bodies(lower=BLOCK.replace("}", ', base = "rollers", sides = "guided"}'), upper=PAD),
            WIDER,
        ),
        lambda s: (
            s.bodies,
            s.bodies.half_planes,
            s.bodies.faces_are_true,
            s.bodies.upper.base,
            s.bodies.upper.sides,
        ),
        (
            Bodies(
                lower=Block(width=20, height=3, base="rollers", sides="guided"),
                upper=Pad(width=8, height=5),
            ),
            False,
            True,
            "fixed",
            "free",
        ),
    ),
    "a gap between flat faces": (
        (bodies(lower=BLOCK, upper=BLOCK),),
        lambda s: s.bodies.faces_are_true,
        False,
    ),
    "arcs that end farther out": ((with_flat(23.9),), lambda s: s.bodies.upper.width, 23.9),
    "a pad as wide as its block": (
        (bodies(lower=NARROW, upper=PAD), WIDER),
        lambda s: s.bodies.lower.width,
        8,
    ),
}
READ |= {
    units: ((("\n[material]", f'\nunits = "{units}"\n[material]'),), lambda s: s.units, units)
    for units in UNITS
}
READ |= {
    f"cylinders {number}": (
        (bodies(**cylinders), ("radius = 2.0", "radius = 20.0")),
        lambda s: round(s.bodies.relative_radius(), 12),
        20.0,
    )
    for number, cylinders in enumerate(CYLINDERS)
}


@pytest.mark.parametrize("name", READ)
def test_what_a_file_says_is_read_from_toml_and_json(name: str, tmp_path: Path) -> None:
    edits, property_of, answer = READ[name]
    text = reduce(lambda text_so_far, edit: text_so_far.replace(*edit), edits, PLAIN)
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8-sig")
    (tmp_path / "mine.json").write_text(json.dumps(tomllib.loads(text)), encoding="utf-8")
    scene = load_scene(tmp_path / "mine.toml")
    assert (
        scene
        == load_scene(str(tmp_path / "mine.json"))
        == Scene.model_validate_json(scene.model_dump_json())
    )
    assert property_of(scene) == answer
    with pytest.raises(Exception, match="frozen"):
        scene.cycles = 3


def test_schema_has_the_rules_and_every_scene_of_the_library_is_valid_by_it() -> None:
    """Short forms and rows from files among them."""
    schema = scene_schema()
    assert schema["additionalProperties"] is False
    assert set(schema["required"]) == {"material", "profile", "friction", "load"}
    assert schema["$defs"]["Friction"]["properties"]["coefficient"]["minimum"] == 0
    ratio = schema["$defs"]["Elastic"]["properties"]["poisson_ratio"]
    assert (ratio["exclusiveMinimum"], ratio["exclusiveMaximum"]) == (-1, 0.5)
    kinds = (
        "hertz",
        "flat_rounded",
        "power_law",
        "compound",
        "wedge",
        "polynomial",
        "tabulated",
        "callable",
        "ellipse",
        "polygon",
    )
    assert not [kind for kind in kinds if f'"{kind}"' not in json.dumps(schema)]
    check = jsonschema.Draft202012Validator(schema)
    for name in scene_names():
        assert not list(check.iter_errors(tomllib.loads(scene_text(name)))), name
    keys = tomllib.loads(scene_text("hertz-paper"))
    for value, right in (
        (0.6, True),
        ({"coefficient": 0.6}, True),
        (-0.6, False),
        ("0.6", False),
        ({"coeff": 1}, False),
    ):
        assert check.is_valid(keys | {"friction": value}) is right, value


# ------------------------------------------------------------------------- units of measured tables
def trace_scene(folder, head, factor, **keys):
    """A parabola of radius 90 mm as a trace whose numbers are `factor` times mm."""
    x = np.linspace(-2.4, 2.4, 61)
    rows = np.column_stack([x + 2.4, x**2 / 180]) * factor
    np.savetxt(folder / "trace.csv", rows, delimiter=",", header=head, comments="", fmt="%.9g")
    scene = {"material": {"young_modulus": 115e3, "poisson_ratio": 0.32}, "friction": 0.5}
    profile = {"kind": "tabulated", "file": "trace.csv", "fit": {"kind": "hertz"}} | keys
    scene |= {
        "profile": profile,
        "load": {"kind": "polygon", "initial_loading": [[120.0, 0.0], [120.0, 35.0]]},
    }
    (folder / "pad.json").write_text(json.dumps(scene))
    return load_scene(folder / "pad.json")


@pytest.mark.parametrize(
    ("head", "factor"),
    [
        ("X_(microns),gap_(microns)", 1e3),
        ("Lateral um,Height um", 1e3),
        ("Raw Micrometer,Fit Micrometer", 1e3),
        ("x_mm,h_mm", 1.0),
        ("x <µm>,h {um}", 1e3),
        ("x [µm] raw,h [µm] levelled", 1e3),
        ("Lateral (in nanometres),Height (in nanometres)", 1e6),
        ("x m,h m", 1e-3),
        ("X millimetres,Z millimetres", 1.0),
        ("a,b\num,um", 1e3),
        ("stage min,profile h", 1.0),
    ],
)
def test_a_unit_is_read_in_any_form_of_a_heading(tmp_path, head, factor):
    scene = trace_scene(tmp_path, head, factor, columns={"x": 1, "h": 2})
    assert scene.profile.radius == pytest.approx(90.0, rel=1e-6)
    read = dict(read_as_by_key(scene)["profile.file"])
    assert repr(head.partition("\n")[0].split(",")[1]) in read["h"]
    assert f"times {1 / factor:.9g}" in read["h"] or "no unit stated" in read["h"]


def test_a_unit_that_is_not_known_is_asked_for_in_one_sentence(tmp_path):
    with refused_for("trace.csv", "'X (furlongs)'", "'furlongs'", "units = {x = 'mm'}"):
        trace_scene(tmp_path, "X (furlongs),h [mm]", 1.0, columns={"x": 1, "h": 2})
    stated = {"columns": {"x": 1, "h": 2}, "units": {"x": "mm"}}
    assert trace_scene(
        tmp_path, "X (furlongs),h [mm]", 1.0, **stated
    ).profile.radius == pytest.approx(90.0, rel=1e-6)


@pytest.mark.parametrize(
    "head",
    [
        "Time,Channel A,Channel B\n(s),(V),(mV)\n\n",
        "x-axis,1,2\nsecond,Volt,Volt\n",
        "Horizontal Units,s\nVertical Units,V,V\nTIME,CH1,CH2\n",
    ],
)
@pytest.mark.parametrize("by_number", [True, False])
def test_a_scale_of_volts_is_asked_for_with_what_it_leads_to(tmp_path, head, by_number):
    (tmp_path / "scope.csv").write_text(head + "".join(f"{k},5,{k}\n" for k in range(9)))
    names = head.replace("second,Volt,Volt\n", "").replace("(s),(V),(mV)\n\n", "")
    columns = dict(zip(("time", "P", "Q"), names.splitlines()[-1].split(","), strict=True))
    if by_number:
        columns = {"time": 1, "P": 2, "Q": 3}
    load = {"kind": "time_series", "file": str(tmp_path / "scope.csv"), "columns": columns}
    with refused_for("'V", "their factor by scale: to loads per unit thickness"):
        load_scene("hertz-paper").vary(load=load, expected=())
