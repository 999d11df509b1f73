"""Shapes of the bodies in a scene: what is read, what is refused and in which sentence, what the shapes say of themselves."""

import math
import tomllib

import pytest

from scenes import Block, Bodies, Cylinder, HalfPlane, InputError, Pad, Scene, load_scene

BLOCK = '{ kind = "block", width = 20.0, height = 10.0 }'
PAD = '{ kind = "pad", width = 8.0, height = 5.0 }'
HERTZ = '{ kind = "hertz", radius = 50.0 }'


def written(folder, bodies, profile=HERTZ):
    """A scene file with the given bodies."""
    text = [
        "material = { young_modulus = 210e3, poisson_ratio = 0.3 }",
        f"profile = {profile}",
        "friction = { coefficient = 0.5 }",
        'load = { kind = "polygon", initial_loading = [[500.0, 0.0], [500.0, 100.0]] }',
        *(f"bodies.{name} = {body}" for name, body in bodies.items()),
    ]
    path = folder / "scene.toml"
    path.write_text("\n".join(text), encoding="utf-8")
    return path


def sentence(folder, bodies, profile=HERTZ):
    path = written(folder, bodies, profile)
    with pytest.raises(InputError) as caught:
        load_scene(path)
    assert "\n" not in str(caught.value)
    return str(caught.value).removeprefix(f"{path}: ")


def test_bodies_are_read(tmp_path):
    held = '{ kind = "block", width = 20.0, height = 10.0, base = "rollers", sides = "guided" }'
    scene = load_scene(written(tmp_path, {"lower": held, "upper": PAD}))
    assert scene.bodies.lower == Block(width=20.0, height=10.0, base="rollers", sides="guided")
    assert scene.bodies.upper == Pad(width=8.0, height=5.0, base="fixed", sides="free")
    assert (scene.bodies.half_planes, scene.bodies.faces_are_true) == (False, True)
    again = Scene.model_validate_json(scene.model_dump_json())
    assert again.bodies == scene.bodies


def test_left_out_they_are_half_planes(tmp_path):
    assert load_scene(written(tmp_path, {})).bodies == Bodies(lower=HalfPlane(), upper=HalfPlane())
    only_one = load_scene(written(tmp_path, {"upper": PAD})).bodies
    assert only_one.lower == HalfPlane()
    assert not only_one.half_planes
    assert not load_scene(written(tmp_path, {"lower": BLOCK, "upper": BLOCK})).bodies.faces_are_true  # a gap between flat faces


@pytest.mark.parametrize(
    ("bodies", "words"),
    [
        (
            {"lower": BLOCK, "upper": '{ kind = "pad", width = 28.0, height = 5.0 }'},
            "bodies is refused: the upper body, a pad of width 28, is wider than the block that it faces, of width 20: make the "
            "pad narrower or the block wider",
        ),
        (
            {"lower": '{ kind = "pad", width = 28.0, height = 5.0 }', "upper": BLOCK},
            "bodies is refused: the lower body, a pad of width 28, is wider than the block that it faces, of width 20: make the "
            "pad narrower or the block wider",
        ),
        (
            {"lower": PAD, "upper": PAD},
            "bodies is refused: a pad on a pad: a pad faces a half_plane or a block, for the profile is its own alone",
        ),
        (
            {"lower": '{ kind = "cylinder", radius = 50.0 }', "upper": PAD},
            "bodies is refused: a pad on a cylinder: a pad faces a half_plane or a block, for the profile is its own alone",
        ),
        (
            {"lower": '{ kind = "cylinder", radius = 25.0 }', "upper": '{ kind = "cylinder", radius = 75.0 }'},
            "profile is not that of the cylinders: it is kind = 'hertz' with radius = 18.75 "
            "(1/R is the sum of 1/radius over the cylinders)",
        ),
        (
            {"upper": '{ kind = "pad", width = 100.0, height = 60.0 }'},
            "bodies.upper.width = 100 goes past the end of the pad's arcs, at 100: make it less",
        ),
        ({"upper": '{ kind = "pad", width = 0.0, height = 5.0 }'}, "bodies.upper.width = 0.0 is refused: should be greater than 0"),
        ({"lower": '{ kind = "cylinder", radius = -1.0 }'}, "bodies.lower.radius = -1.0 is refused: should be greater than 0"),
        (
            {"lower": '{ kind = "block", width = 8.0, height = 5.0, base = "glued" }'},
            "bodies.lower.base = 'glued' is refused: should be 'fixed' or 'rollers'",
        ),
        (
            {"lower": '{ kind = "block", width = 8.0, height = 5.0, sides = "fixed" }'},
            "bodies.lower.sides = 'fixed' is refused: should be 'free' or 'guided'",
        ),
        ({"lower": '{ kind = "block", width = 8.0 }'}, "the key bodies.lower.height is missing"),
        ({"lower": '{ kind = "block", width = 8.0, height = 5.0, depth = 1.0 }'}, "unknown key bodies.lower.depth = 1.0"),
        ({"lower": "{ width = 8.0, height = 5.0 }"}, "the key bodies.lower.kind is missing"),
        ({"lower": '{ kind = "disc", radius = 8.0 }'}, "bodies.lower.kind = 'disc' is refused: should be"),
        ({"middle": BLOCK}, "unknown key bodies.middle"),
    ],
)
def test_refusals(tmp_path, bodies, words):
    assert sentence(tmp_path, bodies).startswith(words)


def test_a_pad_with_a_flat_ends_later(tmp_path):
    rounded = '{ kind = "flat_rounded", radius = 10.0, flat_half_length = 2.0 }'
    wide, wider = ('{ kind = "pad", width = %s, height = 12.0 }' % width for width in (23.9, 24.0))  # noqa: UP031
    load_scene(written(tmp_path, {"upper": wide}, rounded))
    assert "past the end of the pad's arcs, at 24" in sentence(tmp_path, {"upper": wider}, rounded)


@pytest.mark.parametrize(("lower", "upper"), [(30.0, 60.0), (60.0, 30.0)])
def test_cylinders_make_the_relative_radius(tmp_path, lower, upper):
    bodies = {"lower": f'{{ kind = "cylinder", radius = {lower} }}', "upper": f'{{ kind = "cylinder", radius = {upper} }}'}
    scene = load_scene(written(tmp_path, bodies, '{ kind = "hertz", radius = 20.0 }'))
    assert scene.bodies.relative_radius() == pytest.approx(20.0, rel=1e-15)
    assert Bodies(upper=Cylinder(radius=7.0)).relative_radius() == pytest.approx(7.0, rel=1e-15)
    assert Bodies(upper=Pad(width=1.0, height=1.0)).relative_radius() is None


def test_half_widths_of_faces():
    assert HalfPlane().face_half_width == math.inf
    assert Pad(width=8.0, height=5.0).face_half_width == Block(width=8.0, height=2.0).face_half_width == 4.0
    assert Cylinder(radius=3.0).face_half_width == 3.0


def test_a_pad_as_wide_as_its_block_is_admitted(tmp_path):
    load_scene(written(tmp_path, {"lower": '{ kind = "block", width = 8.0, height = 10.0 }', "upper": PAD}))


def test_bodies_are_physics_and_count_in_equality(tmp_path):
    one, other = (load_scene(written(tmp_path, {"lower": BLOCK, "upper": body})) for body in (PAD, PAD.replace("5.0", "6.0")))
    assert one != other
    assert tomllib.loads(written(tmp_path, {"upper": PAD}).read_text("utf-8"))["bodies"]["upper"]["kind"] == "pad"
