"""Studies: read and refused in sentences, expanded to the points that they say, addressed by what numbers depend on."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reports.sweep.axes import Axis, Span, Steps, grid, hypercube
from reports.sweep.expressions import evaluate
from reports.sweep.grouping import plan, tasks
from reports.sweep.points import expand
from reports.sweep.study import Study, load_study, study_of
from scenes import InputError, load_scene


def study(**changes: Any) -> Study:
    """Half-plane theory on hertz-paper over two frictions, changed."""
    data: dict[str, Any] = {
        "scene": "hertz-paper",
        "engines": ["exact"],
        "figures": ["exact.dissipation"],
        "axes": [{"name": "f", "key": "friction.coefficient", "values": [1.0, 2.0]}],
    }
    return study_of(data | changes, "study.toml")


class TestAxes:
    def test_grid_runs_the_last_axis_first(self) -> None:
        axes = [Axis(name="a", values=(1, 2)), Axis(name="b", values=("x", "y"))]
        assert [(p["a"], p["b"]) for p in grid(axes, 0, 0)] == [(1, "x"), (1, "y"), (2, "x"), (2, "y")]

    def test_logarithmic_steps_have_one_ratio_and_both_ends(self) -> None:
        values = [p["h"] for p in Axis(name="h", logarithmic=Steps(start=2, stop=32, count=5)).settings()]
        assert values == pytest.approx([2, 4, 8, 16, 32], rel=1e-15)

    def test_pairs_go_together(self) -> None:
        axis = Axis(names=("base", "sides"), pairs=(("fixed", "free"), ("rollers", "guided")))
        assert list(grid([axis], 0, 0)) == [{"base": "fixed", "sides": "free"}, {"base": "rollers", "sides": "guided"}]

    def test_latin_hypercube_has_one_sample_in_each_part_of_each_axis(self) -> None:
        axes = [
            Axis(name="a", latin_hypercube=Span(start=0, stop=1)),
            Axis(name="b", latin_hypercube=Span(start=1, stop=100, logarithmic=True)),
        ]
        drawn = hypercube(axes, 50, 7)
        assert sorted(int(50 * float(p["a"])) for p in drawn) == list(range(50))
        assert sorted(int(25 * np.log10(float(p["b"]))) for p in drawn) == list(range(50))
        assert drawn == hypercube(axes, 50, 7)
        assert drawn != hypercube(axes, 50, 8)

    def test_a_hypercube_is_taken_with_every_setting_of_the_other_axes(self) -> None:
        axes = [Axis(name="a", latin_hypercube=Span(start=0, stop=1)), Axis(name="b", values=(1, 2, 3))]
        assert len(list(grid(axes, 4, 0))) == 12


class TestExpressions:
    def test_arithmetic(self) -> None:
        assert evaluate("-2**2 + sqrt(a)*max(1, b)/4", {"a": 16.0, "b": 3}) == pytest.approx(-1.0)

    @pytest.mark.parametrize(
        "text",
        [
            "__import__('os')",
            "a.real",
            "[1]",
            "1 if a else 2",
            "b",
            "1/0",
            "10**400",
            "sqrt(-1)",
            "lambda: 1",
            "a if",
            "'x'",
            "9**9**9**9",
        ],
    )
    def test_anything_else_is_refused(self, text: str) -> None:
        with pytest.raises(InputError):
            evaluate(text, {"a": 1.0})


class TestReading:
    @pytest.mark.parametrize(
        ("changes", "words"),
        [
            ({"axess": []}, "unknown key axess"),
            ({"engine": ["fe"]}, r"unknown key engine = .*; did you mean engines\?"),  # `engine` is a key of the scene's tables
            ({"axes": [{"name": "f", "key": "friction.coefficient"}]}, "exactly one of"),
            ({"axes": [{"name": "f", "values": [1.0]}]}, "moves nothing"),
            ({"figures": ["error.dissipation"]}, "needs engines"),
            ({"figures": ["exact.nothing"]}, "is none"),
            ({"figures": ["exact.dissipation", "exact.dissipation"]}, "twice"),
            ({"uncertainty": "cheap"}, "exact to rounding"),
            ({"samples": 3}, "latin_hypercube"),
            ({"scene": "hertz-papr"}, "hertz-papr"),
            ({"set": {"friction.coefficient": 1.0}}, "given twice"),
            (
                {"axes": [{"name": "f", "key": "friction.coefficient", "logarithmic": {"start": 0, "stop": 1, "count": 2}}]},
                "start > 0",
            ),
        ],
    )
    def test_a_wrong_study_is_refused_in_a_sentence(self, changes: dict[str, Any], words: str) -> None:
        with pytest.raises(InputError, match=words):
            study(**changes)

    def test_a_study_file_finds_its_scene_beside_it(self, tmp_path: Path) -> None:
        (tmp_path / "own.json").write_text(load_scene("hertz-paper").model_dump_json(), encoding="utf-8")
        text = 'scene = "own.json"\nengines = ["exact"]\nfigures = ["exact.dissipation"]\n'
        text += '[[axes]]\nname = "f"\nkey = "friction.coefficient"\nvalues = [1]\n'
        (tmp_path / "study.toml").write_text(text, encoding="utf-8")
        assert load_study(tmp_path / "study.toml").scene.profile == load_scene("hertz-paper").profile

    def test_a_study_comes_back_from_its_own_json(self) -> None:
        asked = study(axes=[{"names": ["f", "n"], "keys": ["friction.coefficient", "cycles"], "pairs": [[1.0, 3], [2.0, 4]]}])
        assert study_of(json.loads(asked.model_dump_json()), "again") == asked


class TestPoints:
    def test_axes_set_and_derived_reach_the_scene_and_the_settings(self) -> None:
        asked = study(
            engines=["fe"],
            figures=["fe.dissipation"],
            axes=[{"name": "r", "values": [500.0]}, {"name": "n", "key": "solver.steps_per_cycle", "values": [48]}],
            set={"mesh.element_size": 0.1, "load.initial_loading": "straight"},
            derived={"k": "1000/r", "profile.radius": "r", "load.mean_normal_load": "90*k"},
            preset="coarse",
        )
        [point] = expand(asked)
        assert point.scene.profile == load_scene("hertz-paper").profile.vary(radius=500.0)
        assert point.scene.load.model_dump()["mean_normal_load"] == 180.0
        assert point.scene.load.model_dump()["initial_loading"] == "straight"
        assert (point.mesh.element_size, point.mesh.growth, point.solver.steps_per_cycle) == (0.1, 0.5, 48)

    @pytest.mark.parametrize(
        ("axis", "words"),
        [
            ({"name": "f", "key": "friction.coefficient", "values": [1.0, 0.1]}, r"point 1 \(f = 0.1\).*gross sliding"),
            ({"name": "f", "key": "friction.coefficient", "values": [1.0, -1.0]}, r"point 1 \(f = -1\).*friction.coefficient"),
            ({"name": "f", "key": "friktion.coefficient", "values": [1.0]}, "the scene has no friktion; known there:.*friction"),
            ({"name": "f", "key": "friction.coeff", "values": [1.0]}, r"friction.coeff = 1.0; did you mean coefficient\?"),
            ({"name": "f", "key": "profile.radius", "values": ["x"]}, "profile.radius = 'x' is refused: should be a valid number"),
            ({"name": "f", "key": "mesh.size", "values": [1.0]}, "mesh.size: there is no such setting"),
            ({"name": "f", "key": "mesh.element_size", "values": [7.0]}, "element_size = 7.0 is refused"),
            ({"name": "f", "key": "solver.steps_per_cycle", "values": [7.5]}, "it is a whole number"),
            ({"name": "f", "key": "friction.coefficient", "values": [1.0, 1]}, "point 1 .* asks the same as point 0"),
        ],
    )
    def test_every_point_is_checked_before_anything_starts(self, axis: dict[str, Any], words: str) -> None:
        with pytest.raises(InputError, match=words):
            expand(study(axes=[axis]))

    def test_supports_are_checked_too(self) -> None:
        axes = [{"name": "base", "key": "bodies.lower.base", "values": ["fixed", "rollers"]}]
        with pytest.raises(InputError, match="nothing holds the block"):
            expand(study(scene="blocks", engines=["fe"], figures=["fe.dissipation"], axes=axes))

    def test_words_and_tolerances_don_t_change_an_address_and_figures_do(self) -> None:
        def address(**changes: Any) -> str:
            return expand(study(**changes))[0].address

        plain = address()
        assert plain == address(title="other", set={"title": "other", "tolerances.shear": 1.0})
        assert plain != address(figures=["exact.peak_pressure"])
        assert plain != address(set={"load.mean_tangential_load": 1.0})
        assert plain == address(set={"mesh.element_size": 0.1})  # theory alone has no mesh
        both = {"engines": ["exact", "fe"]}
        assert address(**both) != address(**both, set={"mesh.element_size": 0.1})
        assert address(**both) != address(**both, share_condensations=False)

    def test_the_code_is_part_of_the_address(self, monkeypatch: pytest.MonkeyPatch) -> None:
        before = expand(study())[0].address
        monkeypatch.setattr("reports.sweep.points.code_versions", lambda: {"code": "other"})
        assert expand(study())[0].address != before


class TestGrouping:
    def test_points_that_differ_in_friction_and_shear_alone_share_their_bodies(self) -> None:
        axes = [
            {"name": "h", "keys": ["bodies.lower.height", "bodies.upper.height"], "values": [5.0, 10.0]},
            {"name": "f", "key": "friction.coefficient", "values": [1.0, 2.0, 3.0]},
        ]
        asked = study(scene="blocks", engines=["fe"], figures=["fe.dissipation"], axes=axes)
        found = plan(asked, expand(asked))
        assert [[p.coordinates["h"] for p in group] for group in found.groups] == [[5.0] * 3, [10.0] * 3]
        assert found.condensations == 2
        unlike = asked.vary(set={"material.lower.young_modulus": 1e5})
        assert plan(unlike, expand(unlike)).condensations == 4
        alone = asked.vary(share_condensations=False)
        assert plan(alone, expand(alone)).condensations == 6

    def test_tasks_hold_every_point_once_and_no_two_groups(self) -> None:
        axes = [{"name": "f", "key": "friction.coefficient", "linear": {"start": 1, "stop": 2, "count": 23}}]
        asked = study(axes=axes)
        points = expand(asked)
        handed = tasks(asked, [points[:9], points[9:]], 2)
        assert sorted(p.number for task in handed for p in task) == list(range(23))
        assert all({p.number < 9 for p in task} in ({True}, {False}) for task in handed)
        assert len(handed) >= 2 * 4
