"""Power of the causes that `halfplane score` names: synthetic results with known faults.

    python benchmarks/power.py DRAWS [SEED]     (the seed is drawn, and printed, if left out)

Each draw takes a scene, no fault, one fault or two, points, instants, noise and printed digits at
random, writes the tractions that another code would then give, and asks `reports.score` for the
cause. Nothing is solved by finite elements: results are half-plane theory, theory with the numbers
of the bodies, or a boundary-element solution with a soft penalty or with unlike materials.

# notation: p pressure, q shear, s slip, f friction, a half-width, P and Q loads, k stiffness of a
penalty
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

import halfplane_fe
import semi_analytic
from reports import score
from scenes import InputError, Materials, Scene, load_scene

Array = NDArray[np.float64]
Draw = np.random.Generator

# Half-planes, real bodies ("blocks"), a bulk stress ("nowell-hills") and a scene without shear.
SCENES = (
    "hertz-paper",
    "cattaneo-mindlin",
    "flat-rounded-paper",
    "hertz-normal",
    "compound-curvature",
    "rounded-wedge",
    "nowell-hills",
    "near-sliding",
    "unload-reload",
    "blocks",
)
# Of the last cycle; one instant is the commonest table of all.
INSTANTS = (1, 5, 13, 25)
FEWEST_POINTS = 12
MOST_POINTS = 200
LARGEST_NOISE = 0.05
# Findings that name no cause: they say that something was not found.
SILENT = ("unknown", "noise", "own_bodies")
# A planted change this many times the noise shall be named.
ABOVE = 2.0
# Cells of the boundary elements, and most states that one step of them may try.
CELLS = 160
MOST_STATES = 30


# ----------------------------------------------------------------------------- a synthetic result
@dataclass(frozen=True, eq=False)
class Question:
    """What a synthetic result is the answer of, and where and when it is told.

    Attributes
    ----------
    scene
        what `score` is given
    solved
        what was solved: the scene, or one with a fault in it
    x, time
        (n_points,) [length], (n_instants,) of the load path
    late
        share of a period by which the tractions are late
    stretch, offset
        x of the file is stretch x + offset
    pressure_factor, shear_factor
        of the tractions in the file
    half_width
        largest one of the scene [length]
    elements
        over the half-width, of a mesh whose nodal forces over the spacing are the tractions; 0: no
        mesh
    penalty
        tangential stiffness k a/E*; 0: none
    beta
        Dundurs' beta of the bodies that were solved
    height
        of the two blocks that were solved [half-widths]; 0: the bodies of the scene
    """

    scene: Scene
    solved: Scene
    x: Array
    time: Array
    half_width: float
    late: float = 0.0
    stretch: float = 1.0
    offset: float = 0.0
    pressure_factor: float = 1.0
    shear_factor: float = 1.0
    elements: float = 0.0
    penalty: float = 0.0
    beta: float = 0.0
    height: float = 0.0

    def answer(self) -> Array:
        """(3, n_instants, n_points): p, q [stress] and s [length] at `x` of the file."""
        x = (self.x - self.offset) / self.stretch
        path = self.scene.load.path()
        times = self.time - self.late * (path.period or 0.0)
        scene = self.solved
        if self.height:
            scene = scene.vary(bodies=_blocks(self.height * self.half_width))
        if self.elements:
            p, q, s = _on_mesh(scene, x, times)
        elif self.penalty or self.beta:
            p, q, s = _boundary_elements(scene, x, times, self.penalty, self.beta)
        else:
            p, q, s = _theory(scene, x, times)
        return np.array([self.pressure_factor * p, self.shear_factor * q, s])


def _blocks(height: float) -> dict[str, dict[str, float | str]]:
    block: dict[str, float | str] = {"kind": "block", "width": 2 * height, "height": height}
    return {"lower": block, "upper": block}


def _theory(scene: Scene, x: Array, times: Array) -> Array:
    """(3, n_instants, n_points): p, q, s of half-plane theory.

    Bodies that are no half-planes have their numbers in it.
    """
    effects = None
    if scene.bodies != load_scene("hertz-paper").bodies:
        effects = halfplane_fe.body_effects(scene)
    unique, places = np.unique(times, return_inverse=True)
    found = semi_analytic.solve(
        scene, x=x, time=unique, fields=("pressure", "shear", "slip"), effects=effects
    )
    return np.array([found.pressure, found.shear, found.slip])[:, places]


def _on_mesh(scene: Scene, nodes: Array, times: Array) -> Array:
    """Nodal forces of theory's tractions over the spacing of the nodes, and theory's slip."""
    spacing = float(nodes[1] - nodes[0])
    fine = np.linspace(nodes[0] - spacing, nodes[-1] + spacing, 40 * len(nodes) + 1)
    p, q, _ = _theory(scene, fine, times)
    hats = np.maximum(1 - np.abs(fine - nodes[:, None]) / spacing, 0.0)
    weights = hats * (fine[1] - fine[0]) / spacing
    return np.array([p @ weights.T, q @ weights.T, _theory(scene, nodes, times)[2]])


def _boundary_elements(scene: Scene, x: Array, times: Array, penalty: float, beta: float) -> Array:
    """Theory's pressure, and the shear of cells of constant shear that slip at q = f p.

    Stick is kept by springs of stiffness k = penalty E*/a (0: none, they are rigid), and the
    pressure moves the faces along x by the coupling of Dundurs' beta; the shear does not change the
    pressure (Goodman's approximation). One step at each event of the path, two revolutions.
    """
    modulus = plane_strain_modulus(scene)
    path = scene.load.path()
    half = float(np.nanmax(np.abs(x)))
    edges = np.linspace(-half, half, CELLS + 1)
    middle = (edges[1:] + edges[:-1]) / 2
    width = edges[1] - edges[0]
    compliance = _influence(middle, width) * 2 / (np.pi * modulus)
    half_width = float(np.nanmax(semi_analytic.solve(scene, x=[0.0], fields=()).contact_half_width))
    spring = half_width / (penalty * modulus) if penalty else 0.0
    matrix = compliance + spring * np.eye(CELLS)
    if path.period is None:
        steps = np.unique(np.concatenate([np.linspace(path.start, path.cycle_start, 9)[1:], times]))
    else:
        first = np.linspace(path.start, path.cycle_start, 5)[1:]
        turns = path.cycle_start + path.period * np.linspace(1, 3, 49)
        steps = np.unique(np.concatenate([first, turns, times]))
    pressure = _theory(scene, middle, steps)[0]
    # relative displacement by the pressure: its slope is 2 beta p/E*
    moved = 2 * beta / modulus * np.cumsum(pressure, axis=1) * width
    moved -= moved.mean(axis=1, keepdims=True)
    friction = scene.friction.coefficient
    tangential = path.at(steps)[1]
    slipped = np.zeros(CELLS)
    answers = {}
    q = np.zeros(CELLS)
    for number, instant in enumerate(steps):
        limit = friction * pressure[number]
        q, shift = _sheared(matrix, width, limit, slipped - moved[number], tangential[number], q)
        free = shift - matrix @ q + moved[number]
        slipped = free
        answers[float(instant)] = (q, free + spring * q)
    rows = [[np.interp(x, middle, field) for field in answers[float(t)]] for t in times]
    shear, slip = np.moveaxis(np.array(rows), 1, 0)
    return np.array([_theory(scene, x, times)[0], shear, slip])


def plane_strain_modulus(scene: Scene) -> float:
    """E*: 1/E* is the sum of (1 - nu^2)/E over both bodies."""
    bodies = (scene.material.upper, scene.material.lower)
    return 1 / sum((1 - body.poisson_ratio**2) / body.young_modulus for body in bodies)


def _influence(middle: Array, width: float) -> Array:
    """Integral of -ln|x - xi| over cells, (n, n)."""
    distance = middle[:, None] - middle[None, :]
    ends = distance + width / 2, distance - width / 2
    left, right = (end * (np.log(np.abs(end)) - 1) for end in ends)
    return np.asarray(right - left)


def _sheared(
    matrix: Array, width: float, limit: Array, slipped: Array, force: float, start: Array
) -> tuple[Array, float]:
    """q of cells with |q| <= limit that add up to `force`, and the shift U of the upper body.

    Cells that stick have U - matrix q = slipped; the others have slipped with the shear.
    """
    count = len(limit)
    pressed = limit > 1e-9 * limit.max()
    state = np.zeros(count)
    q = start
    shift = 0.0
    for _ in range(MOST_STATES):
        stick = pressed & (state == 0)
        given = np.where(pressed, state * limit, 0.0)
        inside = np.flatnonzero(stick)
        system = np.zeros((len(inside) + 1, len(inside) + 1))
        system[:-1, :-1] = matrix[np.ix_(inside, inside)]
        system[:-1, -1] = -1.0
        system[-1, :-1] = width
        right = np.append(-slipped[inside] - (matrix[inside] @ given), force - width * given.sum())
        if not len(inside):
            break
        solution = np.linalg.solve(system, right)
        q = given.copy()
        q[inside] = solution[:-1]
        shift = float(solution[-1])
        slip = shift - matrix @ q - slipped
        beyond = stick & (np.abs(q) > limit)
        back = pressed & (state != 0) & (slip * state < 0)
        new = np.where(beyond, np.sign(q), np.where(back, 0.0, state))
        if np.array_equal(new, state):
            break
        state = new
    return q, shift


# ----------------------------------------------------------------------------------- the faults
@dataclass(frozen=True)
class Planted:
    """A fault.

    Attributes
    ----------
    name
        in the table
    keys
        `Diagnosis.fault` of the findings that name it
    plant
        the question with the fault in it; None where the question can't have it
    """

    name: str
    keys: tuple[str, ...]
    plant: Callable[[Question, Draw], Question | None]


def _factor(draw: Draw, nearest: float, farthest: float) -> float:
    """1/farthest to 1/nearest, or nearest to farthest."""
    factor = float(np.exp(draw.uniform(np.log(nearest), np.log(farthest))))
    return factor if draw.random() < 0.5 else 1 / factor


def _slips(question: Question) -> bool:
    """Whether the scene has a shear."""
    scene = question.scene
    q = scene.load.path().at(question.time)[1]
    return bool(scene.friction.coefficient) and bool(np.any(q))


def _other_friction(question: Question, draw: Draw) -> Question | None:
    if not _slips(question):
        return None
    f = question.solved.friction.coefficient * _factor(draw, 1.15, 2.0)
    return replace(question, solved=question.solved.vary(friction=f))


def stiffer(scene: Scene, factor: float) -> Scene:
    """E of both bodies times `factor`."""
    upper, lower = (
        body.vary(young_modulus=factor * body.young_modulus)
        for body in (scene.material.upper, scene.material.lower)
    )
    return scene.vary(material=Materials(upper=upper, lower=lower))


def _other_modulus(question: Question, draw: Draw) -> Question:
    return replace(question, solved=stiffer(question.solved, _factor(draw, 1.1, 2.5)))


def _other_loads(question: Question, draw: Draw) -> Question:
    """Loads k times the scene's: k times the tractions of bodies 1/k times as stiff."""
    k = _factor(draw, 1.08, 2.0)
    return replace(
        question,
        solved=stiffer(question.solved, 1 / k),
        pressure_factor=k * question.pressure_factor,
        shear_factor=k * question.shear_factor,
    )


def _other_traction_unit(question: Question, draw: Draw) -> Question:
    k = _factor(draw, 1.08, 2.0)
    return replace(
        question,
        pressure_factor=k * question.pressure_factor,
        shear_factor=k * question.shear_factor,
    )


def _stretched(question: Question, draw: Draw) -> Question:
    return replace(question, stretch=_factor(draw, 1.08, 2.0))


def _moved(question: Question, draw: Draw) -> Question:
    distance = draw.uniform(0.04, 0.4) * draw.choice([-1.0, 1.0])
    return replace(question, offset=float(distance) * question.half_width)


def _turned(question: Question, _draw: Draw) -> Question | None:
    if not _slips(question):
        return None
    return replace(question, shear_factor=-question.shear_factor)


def _late(question: Question, draw: Draw) -> Question | None:
    path = question.scene.load.path()
    if path.period is None or len(question.time) < 5:
        return None
    return replace(question, late=float(draw.uniform(0.04, 0.5)))


def _coarse(question: Question, draw: Draw) -> Question:
    """So many points that their spacing is the element length, over a wide stretch of surface."""
    elements = float(draw.uniform(0.6, 3.5))
    spacing = question.half_width / elements
    count = max(FEWEST_POINTS // 2, round(1.8 * elements))
    nodes = spacing * (np.arange(-count, count + 1) + draw.uniform(0.0, 1.0))
    return replace(question, elements=elements, x=nodes)


def _creeping(question: Question, draw: Draw) -> Question | None:
    if not _slips(question) or question.scene.unsymmetric or len(question.time) < 5:
        return None
    return replace(question, penalty=float(np.exp(draw.uniform(np.log(0.7), np.log(10)))))


def _body(question: Question, draw: Draw) -> Question | None:
    """Two blocks in place of half-planes."""
    if question.scene.name == "blocks" or question.scene.unsymmetric:
        return None
    return replace(question, height=float(draw.uniform(2.5, 6.0)))


def _unlike(question: Question, draw: Draw) -> Question | None:
    if not question.scene.friction.coefficient or question.scene.unsymmetric:
        return None
    return replace(question, beta=float(draw.uniform(0.1, 0.3)))


FAULTS = (
    Planted("friction", ("friction",), _other_friction),
    Planted("modulus", ("stiffness",), _other_modulus),
    Planted("loads", ("loads", "half_model"), _other_loads),
    Planted("traction unit", ("traction_factor", "units"), _other_traction_unit),
    Planted("scale of x", ("x_scale",), _stretched),
    Planted("offset", ("offset",), _moved),
    Planted("sign of shear", ("shear_sign",), _turned),
    Planted("instant", ("other_times",), _late),
    Planted("coarse mesh", ("coarse_edge",), _coarse),
    Planted("soft penalty", ("elastic_slip",), _creeping),
    Planted("finite body", ("small_body",), _body),
    Planted("unlike bodies", ("coupling",), _unlike),
)
# Faults of the model are solved in one way each, and go with no other of them.
OF_MODEL = {"coarse mesh", "soft penalty", "finite body", "unlike bodies"}
# Two of these amount to a third one: loads and a modulus of one factor are a factor of the
# tractions; under a Hertz contact any two are any other two. No file tells them apart.
OF_SIZE = {"modulus", "loads", "traction unit", "scale of x", "finite body"}


# --------------------------------------------------------------------------------------- the draws
@dataclass(frozen=True)
class Outcome:
    """One draw: what was planted, how far above the noise, and what was named.

    Attributes
    ----------
    scene, points, instants, noise, digits
        of the draw
    planted
        names of the faults
    above
        those whose change of the tractions is more than twice the noise
    named
        `Diagnosis.fault` of every cause that was named
    judged
        whether the result is outside its tolerances
    refused
        the sentence by which the result was refused
    """

    scene: str
    points: int
    instants: int
    noise: float
    digits: int
    planted: tuple[str, ...]
    above: tuple[str, ...]
    named: tuple[str, ...]
    judged: bool
    refused: str = ""

    @property
    def causes(self) -> set[str]:
        """Names of the faults that were named; the key itself where no planted fault has it."""
        names = set()
        for key in self.named:
            owners = [fault.name for fault in FAULTS if key in fault.keys]
            names.add(owners[0] if owners else key)
        return names

    @property
    def verdict(self) -> str:
        """ "wrong" if a cause is named that was not planted; "right" if every fault above the noise
        is named; "part" if some are; else "none".
        """
        if self.causes - set(self.planted):
            return "wrong"
        if not self.causes:
            return "none"
        return "right" if set(self.above) <= self.causes else "part"

    @property
    def words(self) -> str:
        """One line."""
        return (
            f"{self.verdict:5} {' + '.join(self.planted) or 'no fault'} ({self.scene},"
            f" {self.points} points, {self.instants} instants, noise {self.noise:.3f},"
            f" {self.digits} digits; above: {' + '.join(self.above) or '-'}):"
            f" {', '.join(self.named) or self.refused or '-'}"
        )


def _question(draw: Draw) -> Question:
    """A scene with points and instants of its last cycle."""
    scene = load_scene(str(draw.choice(SCENES)))
    path = scene.load.path()
    half_width = float(np.nanmax(semi_analytic.solve(scene, x=[0.0], fields=()).contact_half_width))
    points = round(np.exp(draw.uniform(np.log(FEWEST_POINTS), np.log(MOST_POINTS))))
    reach = draw.uniform(1.1, 1.8)
    x = half_width * np.linspace(-reach, reach, points)
    count = int(draw.choice(INSTANTS))
    if path.period is None:
        times = np.linspace(path.start, path.cycle_start, count + 1)[1:]
    elif count == 1:
        times = path.cycle_start + path.period * (2 + draw.uniform(0.0, 1.0, 1))
    else:
        times = path.cycle_start + path.period * (2 + np.linspace(0, 1, count))
    return Question(scene, scene, x, times, half_width)


def _printed(values: Array, digits: int) -> Array:
    """As a table with so many significant digits has it."""
    return np.array([float(f"{value:.{digits - 1}e}") for value in values.flat]).reshape(
        values.shape
    )


def drawn(draw: Draw) -> Outcome:
    """One draw, scored."""
    for _ in range(100):
        question = _question(draw)
        wanted = int(draw.choice([0, 1, 2], p=[0.2, 0.5, 0.3]))
        chosen = [FAULTS[k] for k in draw.choice(len(FAULTS), wanted, replace=False)]
        names = {fault.name for fault in chosen}
        if len(OF_MODEL & names) > 1 or len(OF_SIZE & names) > 1:
            continue
        with_all: Question | None = question
        # the mesh first, whose points are its own
        for fault in sorted(chosen, key=lambda fault: fault.name != "coarse mesh"):
            with_all = with_all and fault.plant(with_all, draw)
        if with_all is None:
            continue
        try:
            return _scored(with_all, chosen, draw)
        except (InputError, np.linalg.LinAlgError):  # gross sliding, separation
            continue
    raise RuntimeError("no draw in 100 tries")


def _scored(question: Question, chosen: Iterable[Planted], draw: Draw) -> Outcome:
    noise = float(draw.choice([0.0, draw.uniform(0.0, LARGEST_NOISE)]))
    digits = int(draw.choice([3, 4, 6, 9]))
    clean = question.answer()
    peaks = np.abs(clean).max(axis=(1, 2), keepdims=True)
    noisy = clean + noise * peaks * draw.standard_normal(clean.shape) * (clean[0] > 0)
    noisy[0] = np.maximum(noisy[0], 0.0)
    written = np.array([_printed(values, digits) for values in noisy])
    carried = clean[0] > 0
    scales = np.where(peaks > 0, peaks, 1.0)
    size_of_noise = _rms(((written - clean) / scales)[:2], carried)
    planted = tuple(fault.name for fault in chosen)
    above = tuple(
        name
        for name in planted
        if _rms(((clean - _without(question, name).answer()) / scales)[:2], carried)
        > ABOVE * size_of_noise
    )
    shear = None if not np.any(written[1]) else written[1]
    slip = written[2] if len(question.time) > 1 and np.any(written[2]) else None
    refused = ""
    named: tuple[str, ...] = ()
    judged = True
    try:
        report = score(
            question.x,
            written[0],
            shear,
            slip=slip,
            scene=question.scene,
            time=question.time,
            code="drawn",
        )
    except InputError as fault:
        refused = str(fault)
    else:
        named = tuple(one.fault for one in report.diagnoses if one.fault not in SILENT)
        judged = report.comparison.verdict != "within"
    return Outcome(
        question.scene.name,
        len(question.x),
        len(question.time),
        noise,
        digits,
        planted,
        above if judged else (),
        named,
        judged,
        refused,
    )


def _without(question: Question, name: str) -> Question:
    """The question with one fault taken out; of a mesh the points stay."""
    plain = question.scene
    match name:
        case "friction":
            solved = question.solved.vary(friction=plain.friction.coefficient)
            return replace(question, solved=solved)
        case "modulus":
            return replace(question, solved=question.solved.vary(material=plain.material))
        case "loads":
            solved = question.solved.vary(material=plain.material)
            return replace(question, solved=solved, pressure_factor=1.0, shear_factor=1.0)
        case "traction unit":
            return replace(question, pressure_factor=1.0, shear_factor=1.0)
        case "sign of shear":
            return replace(question, shear_factor=abs(question.shear_factor))
    attribute = {
        "scale of x": {"stretch": 1.0},
        "offset": {"offset": 0.0},
        "instant": {"late": 0.0},
        "coarse mesh": {"elements": 0.0},
        "soft penalty": {"penalty": 0.0},
        "finite body": {"height": 0.0},
        "unlike bodies": {"beta": 0.0},
    }[name]
    return replace(question, **attribute)


def _rms(values: Array, where: NDArray[np.bool_]) -> float:
    """Over the points `where` there is a pressure and both tractions."""
    return float(np.sqrt(np.mean(values[:, where] ** 2))) if where.any() else 0.0


def measured(count: int, seed: int) -> list[Outcome]:
    """So many draws; each has a generator of its own, so that any one can be repeated."""
    return [drawn(np.random.default_rng([seed, number])) for number in range(count)]


def table(outcomes: list[Outcome]) -> str:
    """Rows of faults: how many were above the noise, named right, in part, wrong, not."""
    groups = {"no fault": [one for one in outcomes if not one.planted]}
    for fault in FAULTS:
        groups[fault.name] = [one for one in outcomes if one.planted == (fault.name,)]
    groups["two faults"] = [one for one in outcomes if len(one.planted) == 2]
    groups["all with a fault"] = [one for one in outcomes if one.planted]
    lines = ["| planted | draws | above | right | part | none | wrong (of all draws) |"]
    lines.append("|---|---|---|---|---|---|---|")
    for name, group in groups.items():
        above = [one for one in group if one.above]
        counts = Counter(one.verdict for one in above)
        wrong = sum(one.verdict == "wrong" for one in group)
        lines.append(
            f"| {name} | {len(group)} | {len(above)} | {counts['right']} | {counts['part']} |"
            f" {counts['none']} | {wrong} |"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    draws = int(sys.argv[1])
    chosen_seed = int(sys.argv[2]) if len(sys.argv) > 2 else int(time.time())
    print(f"seed {chosen_seed}, {draws} draws")
    results = []
    for number in range(draws):
        results.append(drawn(np.random.default_rng([chosen_seed, number])))
        print(results[-1].words, flush=True)
    print(table(results))
