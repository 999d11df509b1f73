"""The form of the answer: read-only, the same after NetCDF, and its last cycle."""

import subprocess
import sys
from dataclasses import fields, is_dataclass, replace

import h5py
import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import reports.page.notebook  # noqa: F401  (registers the figures of a solution)
import semi_analytic
from scenes import InputError, load_scene, notebook_forms
from scenes.solution import ContactSolution, Record, SurfaceState, Work, read_only_copy

STEPS = 7
POINTS = 5
ARRAYS = (
    *(
        "time",
        "normal_load",
        "tangential_load",
        "x",
        "pressure",
        "shear",
        "slip",
        "state",
        "contact_edges",
        "stick_edges",
    ),
    *("contact_half_width", "stick_half_width", "tangential_displacement", "normal_approach"),
    *("dissipation_density", "cycle_dissipation"),
)


def small_solution(scene_name="hertz-paper", time=None):
    """An answer with something in every field, NaN and None included."""
    scene = load_scene(scene_name)
    path = scene.load.path()
    time = (
        np.linspace(path.start, path.cycle_start + 2 * (path.period or 0.0), STEPS)
        if time is None
        else time
    )
    answer = semi_analytic.solve(scene, x=np.linspace(-1, 1, POINTS), time=time)
    series = read_only_copy(np.linspace(0, 1 / 3, len(time)))
    stick_edges = np.array(answer.stick_edges)
    stick_edges[0] = np.nan
    record = Record(
        converged=True,
        termination="steady",
        message="the cycle repeats: 1e-3 < 2",
        iterations=read_only_copy(np.arange(len(time)), np.int64),
        certificates={"cone": series, "energy_balance": -series},
        energy={"external": 2 * series},
        notes=("one", 'two "quoted"'),
    )
    return replace(
        answer,
        engine="test",
        stick_edges=read_only_copy(stick_edges),
        tilt=read_only_copy(series / 3),
        permanent_stick_edges=read_only_copy([-1.0, 2.0]),
        dissipation=0.1 + 0.2,
        permanent_stick_half_width=float("nan"),
        steady_from=None,
        record=record,
        work=Work({"steps": 3}, {"revolutions": (2, "repeats")}, {"mesh": 0.25}),
        settings={"mesh": {"order": 2, "element_size": 0.1}},
        versions={"numpy": "2"},
    )


def parts(value):
    """An answer with its parts, and theirs, by name; arrays with the type of their numbers."""
    if is_dataclass(value):
        return {field.name: parts(getattr(value, field.name)) for field in fields(value)}
    return (value, value.dtype) if isinstance(value, np.ndarray) else value


@pytest.mark.parametrize(
    ("scene_name", "steady_from"), [("hertz-paper", None), ("hertz-paper", 3), ("hertz-normal", 0)]
)
def test_a_dataset_and_a_file_hold_all_of_it(scene_name, steady_from, tmp_path):
    solution = replace(small_solution(scene_name), steady_from=steady_from)
    dataset = solution.to_dataset()
    np.testing.assert_equal(parts(ContactSolution.from_dataset(dataset)), parts(solution))
    solution.save(tmp_path / "answer.nc")
    loaded = ContactSolution.load(tmp_path / "answer.nc")
    np.testing.assert_equal(parts(loaded), parts(solution))
    with pytest.raises(ValueError, match="read-only"):
        loaded.pressure[0, 0] = 1.0
    assert dataset["pressure"].dims == ("time", "x")
    assert dataset["stick_edges"].dims == ("time", "side")
    assert list(dataset["side"].values) == ["left", "right"]
    assert (
        dataset["certificate_cone"].dims
        == dataset["energy_external"].dims
        == dataset["time"].dims
        == ("time",)
    )


def test_a_saved_file_is_what_xarray_writes_of_the_dataset(tmp_path):
    """Variables, types, attributes, coordinates; the file is written without xarray. Files of
    earlier versions were written by it, and are read.
    """
    solution = small_solution("nowell-hills")
    solution.save(tmp_path / "saved.nc")
    solution.to_dataset().to_netcdf(tmp_path / "by_xarray.nc", engine="h5netcdf")
    with (
        xr.open_dataset(tmp_path / "saved.nc", engine="h5netcdf") as saved,
        xr.open_dataset(tmp_path / "by_xarray.nc", engine="h5netcdf") as by_xarray,
    ):
        xr.testing.assert_identical(saved, by_xarray)
        assert set(saved.coords) == {"time", "x", "side"}
        types = {name: variable.dtype for name, variable in saved.variables.items()}
        assert types == {name: variable.dtype for name, variable in by_xarray.variables.items()}
        keys = ("_FillValue", "dtype", "original_shape", "chunksizes", "zlib", "shuffle")
        for name, variable in saved.data_vars.items():
            expected = by_xarray[name].encoding
            for key in keys:
                np.testing.assert_equal(variable.encoding.get(key), expected.get(key))
        assert not any("_FillValue" in axis.encoding for axis in saved.coords.values())
    loaded = ContactSolution.load(tmp_path / "by_xarray.nc")
    np.testing.assert_equal(parts(loaded), parts(solution))


def test_arrays_that_differ_in_the_length_of_an_axis_are_refused(tmp_path):
    path = tmp_path / "answer.nc"
    small_solution().save(path)
    with h5py.File(path, "r+") as file:
        del file["slip"]
        slip = file.create_dataset("slip", data=np.zeros((STEPS, POINTS + 1)))
        slip.dims[0].attach_scale(file["time"])
        slip.dims[1].attach_scale(file["x"])
    with pytest.raises(InputError, match="values over x, and others have"):
        ContactSolution.load(path)


def test_a_file_of_another_format_is_refused_before_its_variables_are_looked_for(tmp_path):
    """Variables of another format may have other names, so a missing one must not be what is
    reported.
    """
    dataset = small_solution().to_dataset().drop_vars("slip")
    later = dataset.assign_attrs(format="halfplane solution 3")
    first = dataset.copy()
    del first.attrs["format"]
    for name, stored, rule in (
        ("later.nc", later, "of a later version"),
        ("first.nc", first, "was written by version 0.1"),
    ):
        stored.to_netcdf(tmp_path / name, engine="h5netcdf")
        with pytest.raises(InputError, match=rf"{name}: .*{rule}"):
            ContactSolution.load(tmp_path / name)


def test_dataset_has_units_long_names_and_coordinates(tmp_path):
    """Of every variable, in the scene's own units; they and the selection by place survive a
    file.
    """
    solution = replace(small_solution(), scene=load_scene("hertz-paper").vary(units="kN, mm, GPa"))
    solution.save(tmp_path / "answer.nc")
    for dataset in (
        solution.to_dataset(),
        xr.load_dataset(tmp_path / "answer.nc", engine="h5netcdf"),
    ):
        named = [name for name in ARRAYS if name in dataset.variables]
        assert set(named) == set(ARRAYS)
        assert all(
            dataset[name].attrs["long_name"] and dataset[name].attrs["units"] for name in named
        )
        assert dataset["pressure"].attrs == {"long_name": "contact pressure p", "units": "GPa"}
        units = [
            dataset[name].attrs["units"]
            for name in ("x", "normal_load", "cycle_dissipation", "state")
        ]
        assert units == ["mm", "kN/mm", "kN·mm/mm", "1"]
        assert float(dataset["pressure"].sel(x=0.5)[3]) == solution.pressure[3, 3]
        assert (
            dataset["pressure"].isel(x=0).sel(time=solution.time[2]).item()
            == solution.pressure[2, 0]
        )
    assert load_scene("hertz-paper").vary(units="whatever").unit_words == (
        "force",
        "length",
        "stress",
    )


def test_without_registered_forms_a_notebook_prints_text_and_figures_are_refused(monkeypatch):
    solution = semi_analytic.solve("hertz-normal")
    monkeypatch.setattr(notebook_forms, "_registered", [])
    assert solution._repr_html_() is None
    assert solution.scene._repr_html_() is None
    for draw in (solution.plot, solution.plot_loop):
        with pytest.raises(InputError, match=r"write `import reports\.page\.notebook`"):
            draw()


@pytest.mark.parametrize(
    "imports",
    [
        "import semi_analytic, reports",
        pytest.param("import reports.page.notebook, semi_analytic", marks=pytest.mark.slow),
        pytest.param("import reports, semi_analytic; reports.compare", marks=pytest.mark.slow),
    ],
)
def test_importing_reports_registers_html_and_figures(imports):
    program = f"{imports}; from scenes.notebook_forms import registered_forms; "
    program += "raise SystemExit(registered_forms() is None)"
    subprocess.run([sys.executable, "-c", program], check=True)


def test_figures_of_a_solution():
    solution = semi_analytic.solve("hertz-paper")
    figure = solution.plot()
    tractions, states = figure.axes
    pressure, shear, *_ = tractions.get_lines()
    steps = solution.last_cycle
    step = steps[np.argmax(np.abs(solution.tangential_load[steps]))]
    np.testing.assert_array_equal(pressure.get_ydata(), solution.pressure[step])
    np.testing.assert_array_equal(shear.get_ydata(), solution.shear[step])
    assert (tractions.get_ylabel(), states.get_xlabel()) == ("p, q [MPa]", "x [mm]")
    assert states.collections[0].get_array().size == len(steps) * len(solution.x)
    np.testing.assert_array_equal(
        solution.plot(time=4.0).axes[0].get_lines()[0].get_ydata(),
        solution.pressure[np.abs(solution.time - 4).argmin()],
    )
    loop = solution.plot_loop()
    np.testing.assert_array_equal(
        loop.axes[0].get_lines()[0].get_xydata()[:, 1], solution.tangential_load[steps]
    )
    assert "W = 0.002058 N·mm/mm per cycle" in loop.axes[0].get_title(loc="left")
    for drawing in (figure, loop):
        drawing.canvas.draw()
        plt.close(drawing)
    plt.close("all")
    with pytest.raises(InputError, match="time = 99 lies outside"):
        solution.plot(time=99)
    alone = semi_analytic.solve("hertz-paper", x=0.0, fields="dissipation")
    for draw, words in (
        (alone.plot, "holds no pressure"),
        (alone.plot_loop, "no relative tangential displacement"),
    ):
        with pytest.raises(InputError, match=words):
            draw()


@pytest.mark.parametrize(
    "scene_name",
    [
        "hertz-paper",
        "hertz-normal",
        "nowell-hills",
        "unload-reload",
        pytest.param("dovetail-out-of-phase", marks=pytest.mark.slow),
    ],
)
def test_a_printed_solution_has_five_lines(scene_name):
    """With the numbers that a reader asks for first, and none of the arrays."""
    solution = semi_analytic.solve(scene_name)
    lines = repr(solution).splitlines()
    assert len(lines) == 5
    assert max(map(len, lines)) <= 120
    assert f"{solution.dissipation:.6g}" in lines[-1]
    assert scene_name in lines[0]
    assert len(repr(solution.record)) < 80


def test_a_solution_is_frozen():
    solution = small_solution()
    mine = np.ones(3)
    for name in ARRAYS:
        with pytest.raises(ValueError, match="read-only"):
            getattr(solution, name)[...] = 0
    with pytest.raises(AttributeError):
        solution.engine = "other"
    frozen = read_only_copy(mine)
    mine[0] = 5.0
    assert frozen.tolist() == [1.0, 1.0, 1.0]
    assert read_only_copy([1, 2], np.int8).dtype == np.int8
    assert {state.name: int(state) for state in SurfaceState} == {
        "OPEN": 0,
        "STICK": 1,
        "SLIP_FORWARD": 2,
        "SLIP_REVERSE": 3,
    }


def test_last_cycle_is_the_last_whole_revolution_with_both_ends_or_the_whole_of_a_path_that_ends():
    path = load_scene("hertz-paper").load.path()
    begin = path.cycle_start
    period = path.period
    way = np.linspace(path.start, begin, 4)
    time_whole = np.concatenate([way, begin + period * np.array([0.25, 0.5, 1.0, 1.5, 1.75, 2.0])])
    # round-off of the last instant must not cost a cycle
    rounded = np.append(time_whole[:-1], time_whole[-1] * (1 - 1e-15))
    for time in (time_whole, rounded):
        assert small_solution(time=time).last_cycle.tolist() == [6, 7, 8, 9]
    unfinished = np.concatenate([way[[0, -1]], begin + period * np.array([0.5, 1.0, 1.25, 1.5])])
    assert small_solution(time=unfinished).last_cycle.tolist() == [1, 2, 3]
    assert small_solution("hertz-normal").last_cycle.tolist() == list(range(STEPS))
