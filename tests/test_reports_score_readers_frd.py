"""The forms .frd and .dat: numbers come back as written, and every fault is refused with its line."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reports.scoring import calculix_files
from reports.scoring.calculix_files import read_dat, read_frd
from scenes import InputError

DATA = Path(__file__).parent / "data"
NODES = ((1, 0.0, 0.0, 0.0), (2, 1.0, 0.0, 0.0), (3, 1.0, 1.0, 0.0), (40, 0.0, 1.0, 0.0))
CONTACT = ("COPEN", "CSLIP1", "CSLIP2", "CPRESS", "CSHEAR1", "CSHEAR2")


def number(value):
    """Twelve characters, as CalculiX prints a float: %12.5E."""
    return f"{value:12.5E}"


def record(node, values, label=10, key="-1"):
    return f" {key}{node:{label}d}" + "".join(map(number, values)) + "\n"


def frd(rows, name="CONTACT", components=CONTACT, *, form=1, time=0.5, count=None, nodes=NODES):
    """A file of four nodes, one quadrangle and one result block."""
    label = {0: 5, 1: 10}[form]
    text = "    1C\n    1UPGM               CalculiX\n    1UVERSION           Version 2.20\n"
    text += f"    2C{'':18}{len(nodes):12d}{'':37}{form}\n" + "".join(record(n, place, label) for n, *place in nodes) + " -3\n"
    text += f"    3C{'':18}{1:12d}{'':37}{form}\n -1{1:{label}d}{9:5d}{0:5d}{1:5d}\n -2"
    text += "".join(f"{n:{label}d}" for n, *_ in nodes) + "\n -3\n"
    text += f"    1PSTEP{1:26d}{1:12d}{1:12d}\n"
    text += f"  100CL  101{number(time)}{len(rows) if count is None else count:12d}{'':20}{0:2d}{1:5d}{'':10}{form:2d}\n"
    text += f" -4  {name:8}{len(components):5d}{1:5d}\n"
    for k, component in enumerate(components):
        text += f" -5  {component:8}{1:5d}{4:5d}{k + 1:5d}{0:5d}\n"
    for node, *values in rows:
        text += record(node, values[:6], label)
        text += "".join(
            record(node, values[k : k + 6], label, "-2").replace(f"{node:{label}d}", " " * label) for k in range(6, len(values), 6)
        )
    return text + " -3\n 9999\n"


def written(tmp_path, text):
    path = tmp_path / "case.frd"
    path.write_text(text)
    return path


# Six digits and two of the exponent is all that twelve characters hold.
SIX_DIGITS = st.builds(lambda m, e: float(f"{m:.5f}E{e}"), st.floats(-9.99999, 9.99999), st.integers(-90, 90))


@given(
    rows=st.lists(st.lists(SIX_DIGITS, min_size=6, max_size=6), min_size=1, max_size=6),
    form=st.sampled_from([0, 1]),
    time=st.floats(1e-6, 1e6).map(lambda t: float(number(t))),
)
def test_numbers_of_fixed_width_come_back_exactly(tmp_path_factory, rows, form, time):
    path = written(tmp_path_factory.mktemp("frd"), frd([(k + 1, *row) for k, row in enumerate(rows)], form=form, time=time))
    (block,) = read_frd(path).blocks
    np.testing.assert_array_equal(block.values, rows)
    np.testing.assert_array_equal(block.nodes, np.arange(len(rows)) + 1)
    assert block.time == time
    assert block.components == CONTACT


@given(columns=st.integers(1, 20), count=st.integers(1, 4))
def test_records_go_on_over_several_lines(tmp_path_factory, columns, count):
    names = tuple(f"C{k}" for k in range(columns))
    values = -np.arange(1.0, 1 + count * columns).reshape(count, columns)
    path = written(tmp_path_factory.mktemp("frd"), frd([(k + 1, *row) for k, row in enumerate(values)], components=names))
    (block,) = read_frd(path).blocks
    np.testing.assert_array_equal(block.values, values)
    np.testing.assert_array_equal(block.column(names[-1]), values[:, -1])


def test_nothing_else_is_in_the_file(tmp_path):
    found = read_frd(written(tmp_path, frd([(1, *range(6))])))
    assert found.version == "CalculiX Version 2.20"
    assert found.names == ("CONTACT",)
    np.testing.assert_array_equal(found.nodes, [1, 2, 3, 40])
    np.testing.assert_array_equal(found.points, [row[1:] for row in NODES])
    assert [(e.number, e.kind, e.nodes) for e in found.elements] == [(1, 9, (1, 2, 3, 40))]
    with pytest.raises(KeyError):
        found.blocks[0].column("CPRES")


def test_blocks_that_are_not_asked_for_are_passed_over(tmp_path):
    found = read_frd(written(tmp_path, frd([(1, 1.0)], "PEEQ", ("PE",))))
    assert found.blocks == ()
    assert found.names == ("PEEQ",)
    assert found.times == (0.5,)


def test_a_component_that_viewers_work_out_is_not_in_the_file(tmp_path):
    text = frd([(1, 1.0, 2.0, 3.0)], "DISP", ("D1", "D2", "D3", "ALL"))
    text = text.replace(f" -5  ALL     {1:5d}{4:5d}{4:5d}{0:5d}", f" -5  ALL     {1:5d}{2:5d}{0:5d}{0:5d}{1:5d}ALL")
    (block,) = read_frd(written(tmp_path, text), ("DISP",)).blocks
    assert block.components == ("D1", "D2", "D3")


def test_an_exponent_of_three_digits_without_its_letter(tmp_path):
    text = frd([(1, 1.5, 2, 3, 4, 5, 6)]).replace(number(1.5), " 1.46685-100")
    assert read_frd(written(tmp_path, text)).blocks[0].values[0, 0] == 1.46685e-100


def test_lines_that_end_as_windows_ends_them(tmp_path):
    path = tmp_path / "case.frd"
    path.write_bytes(frd([(1, *range(6))]).replace("\n", "\r\n").encode())
    np.testing.assert_array_equal(read_frd(path).blocks[0].values, [range(6)])


ROWS = [(1, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5), (40, 0, 0, 0, 0, 0, 0)]
GOOD = frd(ROWS)
LINE = {line: k for k, line in enumerate(GOOD.splitlines(), start=1)}  # the last of equal lines
FIRST = record(*ROWS[0][:1], ROWS[0][1:]).rstrip("\n")
HEAD = next(line for line in LINE if line.startswith("  100C"))


@pytest.mark.parametrize(
    ("old", "new", "line", "said"),
    [
        (number(2.5), "  2.5OOOE+00", LINE[FIRST], "a number, found"),
        (FIRST, FIRST[:-3], LINE[FIRST], r"6 numbers of 12 characters, 85 in all, found 82"),
        (FIRST, FIRST + "E-100", LINE[FIRST], "85 in all, found 90"),
        (f" -1{40:10d}{number(0)}{number(0)}", f" -1{'4O':>10}{number(0)}{number(0)}", LINE[FIRST] + 1, "a node's number"),
        (" -4  CONTACT", " -5  CONTACT", LINE[HEAD] + 1, "the name of a result block"),
        (" -5  CSHEAR2", " -1  CSHEAR2", LINE[HEAD] + 7, "the name of a component"),
        (HEAD, HEAD[:12] + "      second" + HEAD[24:], LINE[HEAD], "the time of a frame"),
        (HEAD, HEAD[:24] + f"{7:12d}" + HEAD[36:], LINE[HEAD], "7 records of block CONTACT as announced here, found 2"),
        (HEAD, HEAD[:24] + "            " + HEAD[36:], LINE[HEAD], "the count of records"),
        (f"{4:12d}{'':37}1\n", f"{5:12d}{'':37}1\n", 4, "5 nodes as announced here, found 4"),
        (f"{1:12d}{'':37}1\n", f"{2:12d}{'':37}1\n", 10, "2 elements as announced here, found 1"),
        (f" -1{40:10d}{number(0)}{number(1)}", f" -1{3:10d}{number(0)}{number(1)}", 5, "every node once"),
        (f" -1{40:10d}{number(0)}{number(1)}", f" -1{40:10d}{number(np.nan)}{number(1)}", 5, "finite coordinates"),
        (f" -2{1:10d}{2:10d}", f" -2{1:10d}{'':10}", 12, "a node's number"),
        (f" -1{1:10d}{9:5d}", f" -2{1:10d}{9:5d}", 11, "the head of an element"),
        (f" -2{1:10d}{2:10d}{3:10d}{40:10d}\n", "", 10, "nodes .-2. of every element, found none of element 1"),
        (" 9999", "    3C", 31, None),
    ],
)
def test_a_fault_is_refused_with_its_line(tmp_path, old, new, line, said):
    assert old in GOOD
    path = written(tmp_path, GOOD.replace(old, new, 1) if old != " 9999" else GOOD[: GOOD.rindex(" -3")])
    with pytest.raises(InputError, match=said or "the file breaks off, 2 lines into the block") as caught:
        read_frd(path)
    if said:
        assert f"case.frd: line {line}: expected" in str(caught.value)


@pytest.mark.parametrize("name", ["mortar.frd", "node-to-surface.frd"])
def test_a_file_that_breaks_off_anywhere_is_refused_or_read_short(tmp_path, name):
    """A run that is still going on: whole blocks may be missing at the end, but no block is read in part."""
    whole = (DATA / name).read_bytes()
    blocks = {b.line: b for b in read_frd(DATA / name).blocks}
    for end in np.linspace(0, len(whole) - 10, 60).astype(int):
        path = tmp_path / "cut.frd"
        path.write_bytes(whole[:end])
        found = read_or_none(path)
        for block in found.blocks if found else ():
            np.testing.assert_array_equal(block.values, blocks[block.line].values)
        assert found is None or not found.ended


def read_or_none(path):
    """None where the file is refused; any other error than InputError is the test's failure."""
    try:
        return read_frd(path)
    except InputError:
        return None


def test_a_binary_file_is_refused_with_the_way_out(tmp_path):
    text = GOOD.replace(f"{4:12d}{'':37}1\n", f"{4:12d}{'':37}3\n", 1)
    with pytest.raises(InputError, match=r"line 4: the file is binary \(form 3\).*\*NODE FILE"):
        read_frd(written(tmp_path, text))


def test_another_kind_of_file_is_refused(tmp_path):
    with pytest.raises(InputError, match="no block of nodes"):
        read_frd(written(tmp_path, "x,p,q\n0,1,2\n"))


def test_a_file_that_is_too_large_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(calculix_files, "LARGEST", 100)
    path = written(tmp_path, GOOD)
    with pytest.raises(InputError, match="at most 100 bytes are read"):
        read_frd(path)
    with pytest.raises(InputError, match="at most 100 bytes are read"):
        read_dat(path)


def test_tables_of_a_printed_file():
    found = read_dat(DATA / "surface-to-surface.dat")
    whats = [(table.what, table.scope, table.time) for table in found.tables]
    assert whats[0] == ("total force", "set BOTTOM", 1.0)
    assert ("contact stress", "all contact elements", 2.0) in whats
    # The support carries what the pad brings.
    np.testing.assert_allclose(found.tables[0].values[0, :2], [0.0, 400.0], atol=1e-3)
    pair = found.pairs[-1]
    assert (pair.slave, pair.master, pair.time) == ("SLOWER", "SUPPER", 2.0)
    np.testing.assert_allclose(pair.force[:2], [60.0, -400.0], rtol=1e-4)
    assert pair.normal[1] == pytest.approx(1.0, abs=1e-4)


TABLE = """
 forces (fx,fy,fz) for set ALL and time  0.5000000E+00

         1  1.000000E+00 -2.000000E+00  3.000000E+00
         7  0.000000E+00  0.000000E+00  0.000000E+00

 contact stress (slave node,press,tang1,tang2) for all contact elements and time 0.5000000E+00

        12  1.000000E+00  2.000000E+00  3.000000E+00
 statistics for slave set A, master set B and time  0.5000000E+00

   total surface force (fx,fy,fz) and moment about the origin (mx,my,mz)

    1.0 2.0 3.0 0.0 0.0 0.0

   center of gravity and mean normal

    0.0 0.0 0.0 0.0 1.0 0.0
"""


def test_numbers_of_nodes_stand_before_the_values(tmp_path):
    path = tmp_path / "case.dat"
    path.write_text(TABLE)
    found = read_dat(path)
    np.testing.assert_array_equal(found.tables[0].ids, [[1], [7]])
    np.testing.assert_array_equal(found.tables[0].values[0], [1.0, -2.0, 3.0])
    np.testing.assert_array_equal(found.tables[1].ids, [[12]])
    np.testing.assert_array_equal(found.pairs[0].force, [1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("-2.000000E+00  3", "************* 3", r"line 4: expected a number"),
        (" 0.000000E+00\n", "\n", r"line 5: expected 4 numbers \(fx,fy,fz\), found 3"),
        ("        12 ", "       1.2 ", "line 9: expected the number of a node"),
        ("        12 ", "", "line 9: expected 4 numbers"),
        ("    1.0 2.0 3.0 0.0", "    1.0 2.0 0.0", "line 14: expected 6 numbers"),
        ("   center of gravity", "   centre of gravity", "line 10: expected 'center of gravity and mean normal' below"),
        (TABLE[TABLE.index("   center") :], "", "line 10: expected 'center of gravity and mean normal' below.*breaks off"),
        (TABLE, "nothing\n", "no table of CalculiX in it"),
    ],
)
def test_a_fault_in_a_printed_file_is_refused_with_its_line(tmp_path, old, new, said):
    assert old in TABLE
    path = tmp_path / "case.dat"
    path.write_text(TABLE.replace(old, new, 1))
    with pytest.raises(InputError, match=said):
        read_dat(path)
