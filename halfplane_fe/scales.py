"""The FE side's own coarse run: how large the contact gets and where its edges travel. No formula
for any profile.

One coarse half-disc serves every size: the compliance of a half-plane has no length in it but the
datum of the normal approach. Bodies with a size of their own are meshed for each size.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
import scipy

from halfplane_fe.actuators import actuators_of, compliance_beyond
from halfplane_fe.contact import BesideTheFaces, ContactProblem, InterfaceState
from halfplane_fe.edges import contact_edges_of_states, stick_edges
from halfplane_fe.interface import (
    Interface,
    condensed_pair,
    couple,
    initial_gap,
    meshed_pair,
    without_mesh_error,
)
from halfplane_fe.mirror import half_interface, is_mirrored, run_at_all_nodes
from halfplane_fe.path import has_bulk_stress, prescribed_path
from halfplane_fe.reported_states import reported_states
from halfplane_fe.run import Pace, PathRun, run_path
from halfplane_fe.supports import bodies_are_alike, has_tangential_load, least_face_half_width
from halfplane_fe.systems import LOADS_ARE_GIVEN, Actuators, Layer
from halfplane_fe.uncertainty import RunValues, run_values
from meshes import MeshSettings, SurfaceGrading
from scenes import (
    NORMAL_LOAD,
    STICK,
    Bodies,
    Elastic,
    InputError,
    Scene,
    TimeSeriesLoad,
)
from scenes.array_types import Mask

# The coarse bodies: a scale good to 1e-3 is needed, and most of the coarse run is the making of
# them.
_COARSE_MESH = MeshSettings(growth=0.4)
# Of the side that may touch the contact shall take between the two fractions; and that side at most
# a share of the face.
_CONTACT_FRACTIONS = (0.6, 0.85)
_SHARE_OF_FACE = 0.97
# Surface elements over that half-width, and regular increments of a revolution.
_N_ELEMENTS = 24
_COARSE_STEPS = 48
# The same of a record of like bodies: two from row to row. Its increments end at events, and W of
# three times as many is the same to 2e-5.
_COARSE_STEPS_OF_RECORD = 16
COARSE_CYCLES = 2
"""Cycles of the coarse run at most."""
UNPLACED_EDGES = "instants without edges between nodes"
"""Name of the count of instants at which no stick edges were located between nodes."""
# The innermost edge is rounded down to this share of the half-width: no last digit of the coarse
# run shall move the mesh.
_ROUNDING_PARTS = 100
# By how much and how often the coarse body grows where the contact reaches its end; `solve` finds
# out if that was not enough.
_ENLARGEMENT = 1.3
_MOST_ENLARGEMENTS = 10


# Factors of e by which the load of an approach is looked for at most, and to which it is found.
_MOST_HALF_RANGES = 20
_TOLERANCE_OF_LOGARITHM = 1e-2
# Where the room is estimated alone: increments of a revolution, by how much the side that may touch
# grows, rows of a record beyond which those of extreme loads stand for all, and the share of the
# largest P below which |Q|/P of a row is not looked at.
_STEPS_OF_ESTIMATE = 12
_FAR_ENLARGEMENT = 2.0
_MOST_ROWS = 16
_LEAST_LOAD_RATIO = 1e-6


@dataclass(frozen=True)
class Scales:
    """Length and load scales of a contact, read off the run on a coarse mesh.

    Attributes
    ----------
    half_width
        contact half-width at the largest load of the path [length]
    inner
        where the surface is to be fine from [length]: the least half-width that a contact or
        stick edge has in a revolution, or the first kink of the profile, whichever is less;
        with bulk stress or tilt the least distance of an edge from x = 0, and 0 where an edge
        crosses it; 0 where the path does not repeat
    reach
        largest distance from x = 0 at which the faces touch [length]
    load
        largest normal load of the path [force per thickness]
    modulus
        E* [stress]
    element_size
        of the surface elements of the coarse run, over the half-width
    dissipation
        friction work of its last revolution [energy / thickness]; NaN in scales that are shared
        with scenes of other loads or friction
    largest_pressure
        at the largest load [stress]
    values
        values of the coarse run. The finer run is compared with them for its uncertainties; None
        in scales that are shared
    """

    half_width: float
    inner: float
    reach: float
    load: float
    modulus: float
    element_size: float
    dissipation: float
    largest_pressure: float
    values: RunValues | None

    def content(self) -> dict[str, float]:
        """The scales by their names, without the values (`RunValues`) of the coarse run."""
        numbers = {field.name: getattr(self, field.name) for field in fields(self)}
        del numbers["values"]
        return numbers


def contact_modulus(lower_material: Elastic, upper_material: Elastic) -> float:
    """E* of two bodies in plane strain: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.

    >>> steel = Elastic(young_modulus=210e3, poisson_ratio=0.3)
    >>> round(contact_modulus(steel, steel), 3)
    115384.615
    """
    return 1 / sum(
        (1 - material.poisson_ratio**2) / material.young_modulus
        for material in (lower_material, upper_material)
    )


def from_datum(scene: Scene, run: PathRun, ratio: float) -> PathRun:
    """Convert normal approach and tangential displacement (`shift`) of a run to another datum
    length, the distance from a force at which a half-plane's surface counts as unmoved.

    The new datum is `ratio` times the run's. Displacements change by a compliance times P or Q; the
    energies in the run stay those of its own datum. The states of the run are scaled, displacements
    over P/E*. `scene` has the bodies, of which half-planes alone count, and their materials.
    """
    modulus = contact_modulus(scene.material.lower, scene.material.upper)
    # displacement between the two datum lengths by a unit load, scaled
    displacement_per_load = compliance_beyond(scene, ratio) * modulus
    moved_states = [
        state.changed(
            approach=state.approach + displacement_per_load * state.normal_load,
            shift=state.shift + displacement_per_load * state.tangential_load,
        )
        for state in run.states
    ]
    return replace(run, states=moved_states)


def largest_load(scene: Scene) -> float:
    """Largest normal load of the path, or approach, at an end of a segment or where it turns round
    within one [force per thickness, or length].
    """
    segments = tuple(prescribed_path(scene).segments(1))  # initial loading and one cycle
    # NORMAL_LOAD: weights 1 and 0 of P and Q
    return max(
        float(
            np.max(
                segment.loads(
                    np.array([segment.start, *segment.turning_points(NORMAL_LOAD), segment.end])
                )[0]
            )
        )
        for segment in segments
    )


def needs_shear(scene: Scene) -> bool:
    """Whether any shear can arise: friction, and a tangential load, a bulk stress or unlike
    bodies.
    """
    has_shear = has_tangential_load(scene) or has_bulk_stress(prescribed_path(scene))
    return scene.friction.coefficient > 0 and (has_shear or not bodies_are_alike(scene))


def is_record(scene: Scene) -> bool:
    """Whether the load of a scene is a record: rows of measured time, P and Q."""
    return isinstance(scene.load, TimeSeriesLoad)


def is_plain_record(scene: Scene) -> bool:
    """Whether the load of a scene is a record of measured rows, on like bodies without bulk stress
    and tilt: then P alone sets the pressure.
    """
    return is_record(scene) and bodies_are_alike(scene) and not scene.unsymmetric


def on_half(scene: Scene, faces: Interface) -> bool:
    """Whether faces and loads of a scene are their own mirror image in x = 0, so that one half of
    the nodes is solved for both. `faces` is the contact compliance.
    """
    return not scene.unsymmetric and is_mirrored(faces, has_tangential_load(scene))


def find_scales(scene: Scene, work_counts: Counter[str]) -> Scales:
    """Length and load scales of a contact, by following its load path on a coarse mesh: half-width,
    edges, largest load, friction work.

    How much of the face the coarse mesh covers follows from the contact itself, found in a few
    normal solutions. Where the approach is prescribed (`load.states_approach`), the load is an
    unknown: a first run with the load of half-planes finds it, a second one is scaled by it.
    `work_counts` counts condensations, the effort of the computation.

    Raises
    ------
    InputError
        If no width of the meshed part of the face holds the contact.
    """
    if not scene.load.states_approach:
        return _scales_at(scene, largest_load(scene), work_counts)
    # The load of half-planes is near enough to choose the width of the mesh.
    load_of_half_planes = _load_of_approach(scene, work_counts)
    largest_load_of_run = _scales_at(scene, load_of_half_planes, work_counts).load
    return _scales_at(scene, largest_load_of_run, work_counts)


def _load_of_approach(scene: Scene, work_counts: Counter[str]) -> float:
    """Estimate of the largest normal load [force per thickness] where an actuator prescribes the
    approach: the load that presses two half-planes together by the largest approach.

    The approach of a half-plane is relative to its surface at a datum length from the contact. The
    load is found by bracketing its logarithm. `work_counts` counts condensations, the effort of the
    computation; `scene` has the rig, bodies, materials and profile.

    Raises
    ------
    InputError
        Where no load within a factor of e^19 has this approach.
    """
    approach = largest_load(scene)
    modulus = contact_modulus(scene.material.lower, scene.material.upper)
    scene_on_half_planes = on_half_planes(scene, _datum_of_approach(scene))
    # bodies on a coarse mesh, with the load that they are pressed by
    coarse_bodies = _CoarseBodies(scene_on_half_planes, 1.0, modulus, work_counts)

    def excess_approach(logarithm: float) -> float:
        """Approach of the actuator at the load of this logarithm, minus the prescribed one."""
        coarse_bodies.load = float(np.exp(logarithm))
        return _approach_of_actuator(coarse_bodies) - approach

    # The bracket grows by a factor of e on both sides, around a load of E* times the approach;
    # _MOST_HALF_RANGES: 20.
    first_logarithm = float(np.log(modulus * approach))
    for half_range in range(1, _MOST_HALF_RANGES):
        lower_end = first_logarithm - half_range
        upper_end = first_logarithm + half_range
        if excess_approach(lower_end) < 0 < excess_approach(upper_end):
            # _TOLERANCE_OF_LOGARITHM: a hundredth
            logarithm = scipy.optimize.brentq(
                excess_approach, lower_end, upper_end, xtol=_TOLERANCE_OF_LOGARITHM
            )
            return float(np.exp(logarithm))
    raise InputError(
        f"load.approach: no load presses the bodies together by {approach:.6g}; check profile and"
        " units"
    )


def _datum_of_approach(scene: Scene) -> float:
    """Distance from the contact at which the surface of a half-plane counts as unmoved where an
    actuator prescribes the approach [length]. It is that of the rig, or else the geometric mean of
    both bodies' depths, each at most the datum length of the profile.
    """
    depths = [body.least_depth for body in (scene.bodies.lower, scene.bodies.upper)]
    reference_lengths = [min(depth, scene.profile.datum_length) for depth in depths]
    return scene.rig.datum_length or float(np.sqrt(reference_lengths[0] * reference_lengths[1]))


def _approach_of_actuator(coarse_bodies: _CoarseBodies) -> float:
    """Approach that a normal actuator needs to press two coarse half-planes together under the load
    of `coarse_bodies` [length]. The actuator yields by its own compliance.
    """
    face_half_width = _fitting_half_width(coarse_bodies)  # of the finely meshed part of the face
    pressed_state = _pressed(coarse_bodies, face_half_width)[1]
    actuator_compliance = actuators_of(coarse_bodies.scene, face_half_width).normal_compliance
    assert actuator_compliance is not None  # for the type checker: the approach is given
    # scaled: under a load of 1 the actuator yields by its compliance
    return (
        (pressed_state.approach + actuator_compliance) * coarse_bodies.load / coarse_bodies.modulus
    )


def on_half_planes(scene: Scene, datum: float) -> Scene:
    """The scene with half-planes in the place of its bodies. Where actuators drive it, their
    movements count from the distance `datum` from the contact [length].
    """
    if not scene.load.is_driven:
        return scene.vary(bodies=Bodies())
    return scene.vary(bodies=Bodies(), rig={"datum_length": datum})


def _scales_at(scene: Scene, load_unit: float, work_counts: Counter[str]) -> Scales:
    """Length and load scales of a contact, read off a run along its load path on a coarse mesh.

    Where the contact touches an end of the finely meshed part of the face, that part is enlarged by
    a factor of 1.3 (`_ENLARGEMENT`), and the run is repeated, ten times at most. The last run is
    accepted even if the contact touches an end: the scales may then be too small. A later solution
    raises ConvergenceError if its contact touches an end of the mesh that they give.

    Parameters
    ----------
    scene
        bodies, materials, profile, friction and loads
    load_unit
        largest normal load, which loads are divided by [force per thickness]
    work_counts
        counts of condensations, the effort of the computation; added to here

    Raises
    ------
    InputError
        Where the contact reaches past the end of the narrower face; where the line of action of the
        loads misses the meshed faces in the last run.
    """
    modulus = contact_modulus(scene.material.lower, scene.material.upper)
    # The bodies on a coarse mesh; `largest_face_half_width`: 0.97 of the half-width of the narrower
    # face. The contact takes 0.6 to 0.85 of the part of the face that is meshed finely.
    coarse_bodies = _CoarseBodies(scene, load_unit, modulus, work_counts)
    face_half_width = _fitting_half_width(coarse_bodies)
    # _COARSE_STEPS_OF_RECORD: increments of a revolution, 16; _COARSE_STEPS: 48
    steps = _COARSE_STEPS_OF_RECORD if is_plain_record(scene) else _COARSE_STEPS
    for enlargements_left in reversed(range(_MOST_ENLARGEMENTS + 1)):
        try:
            # The last revolutions of both runs are compared: with one alone, both are the first.
            n_cycles = min(COARSE_CYCLES, scene.cycles)
            problem, run = _coarse_run(coarse_bodies, face_half_width, steps, n_cycles)
        except BesideTheFaces:  # the line of action of the loads misses the meshed faces
            if not enlargements_left or face_half_width == coarse_bodies.largest_face_half_width:
                raise
        else:
            if not enlargements_left or not _touches_an_end(run):
                break
            # Shear moves the contact of unlike bodies sideways, tilt that of all; the coarse body
            # has to hold that too.
            if face_half_width == coarse_bodies.largest_face_half_width:
                raise _past_the_end(scene)
        face_half_width = min(face_half_width * _ENLARGEMENT, coarse_bodies.largest_face_half_width)
    return _scales_of_run(coarse_bodies, face_half_width, problem, run)


def _scales_of_run(
    coarse_bodies: _CoarseBodies, face_half_width: float, problem: ContactProblem, run: PathRun
) -> Scales:
    """Size and load of a contact, from its states along the load path on a coarse mesh: half-width,
    reach, innermost place of an edge, largest load and pressure, friction work of a revolution.

    From these the fine mesh is chosen. Lengths of the run are over `face_half_width`, forces over
    P, displacements over P/E*. A local that is so divided is called scaled; what is returned is in
    the scene's units.

    Parameters
    ----------
    coarse_bodies
        the coarse bodies, with the load P and the modulus E* that the run is scaled by
    face_half_width
        half the width of the part of the face that may touch [length]
    problem, run
        the contact problem with the places of its nodes, and its states along the load path
    """
    scene = coarse_bodies.scene
    load_unit = coarse_bodies.load
    modulus = coarse_bodies.modulus

    # Half-width at the largest load; largest distance from x = 0 at which the faces touch.
    state_at_largest_load = max(run.states, key=lambda state: state.normal_load)
    edges_at_largest_load = contact_edges_of_states(problem.interface, [state_at_largest_load])
    scaled_half_width = float(np.nan_to_num(np.diff(edges_at_largest_load)[0, 0] / 2))
    scaled_reach = max(
        float(np.abs(problem.interface.x[state.is_closed]).max(initial=0.0)) for state in run.states
    )

    # Innermost place of an edge of contact or stick in the cycles, rounded down to a hundredth of
    # the half-width, so that no last digit of the coarse run moves the mesh.
    # _ROUNDING_PARTS: 100 parts of the half-width
    scaled_innermost_edge = _innermost_edge_of_cycles(scene, problem, run)
    scaled_innermost_edge = (
        np.floor(_ROUNDING_PARTS * scaled_innermost_edge / scaled_half_width)
        / _ROUNDING_PARTS
        * scaled_half_width
    )
    # Fine elements begin at a kink of the profile: the slope of the pressure is infinite there.
    first_kink = min(scene.profile.kinks, default=np.inf)

    # In the scene's units. `values`: results that a finer run is compared with for its
    # uncertainty, displacements counted from the scene's datum length. `states_approach`: the
    # approach is prescribed, so that the largest load is a result. A state's `pressure` holds nodal
    # forces: over the length of face of each node it is a stress.
    # _N_ELEMENTS: 24 surface elements over `face_half_width`
    return Scales(
        half_width=face_half_width * scaled_half_width,
        inner=min(face_half_width * scaled_innermost_edge, first_kink),
        reach=face_half_width * max(scaled_reach, scaled_half_width),
        load=load_unit * state_at_largest_load.normal_load
        if scene.load.states_approach
        else load_unit,
        modulus=modulus,
        element_size=1 / (_N_ELEMENTS * scaled_half_width),
        dissipation=float(run.nodal_work_by_cycle[-1].sum()) * load_unit**2 / modulus,
        largest_pressure=float(
            np.max(state_at_largest_load.pressure / problem.interface.face_lengths)
        )
        * load_unit
        / face_half_width,
        values=run_values(
            from_datum(scene, run, scene.profile.datum_length / face_half_width),
            problem.interface,
            displacement_unit=load_unit / modulus,
            stress_unit=load_unit / face_half_width,
        ),
    )


def _innermost_edge_of_cycles(scene: Scene, problem: ContactProblem, run: PathRun) -> float:
    """Least distance from x = 0 of an edge of contact or stick in all revolutions of a run, scaled;
    0 where the load path does not repeat.

    The first revolution counts too: where its edges turned, q keeps a kink in all later ones.
    `scene` has the load path; `problem` the places of the nodes.
    """
    if prescribed_path(scene).period is None:
        return 0.0
    # indices of the states after the initial loading; `reported_states`: open, stick or slip of
    # each node, without slip that may be round-off or error of the mesh
    rows_of_cycles = slice(run.cycle_starts[0] + 1, None)
    surface_states = reported_states(problem, run.states, run.cycle_starts)[rows_of_cycles]
    return _innermost_edge(
        problem,
        run.states[rows_of_cycles],
        surface_states == STICK,
        stick_may_be_anywhere=scene.unsymmetric,
    )


@dataclass(frozen=True)
class RoomForContact:
    """How large a contact gets on bodies of a size, by few increments on a coarse mesh.

    Attributes
    ----------
    reach
        largest distance from x = 0 at which the faces touch [length]
    room
        half the width of the narrower face [length]
    scales
        what the mesh depends on, see `find_scales`
    """

    reach: float
    room: float
    scales: Scales

    @property
    def in_words(self) -> str:
        """A sentence on how large the contact is on faces of a width (`room`: half of it), how far
        from x = 0 it reaches, and how it was estimated.
        """
        # _STEPS_OF_ESTIMATE: twelve increments
        return (
            f"The bodies have room for the contact: it has the half-width"
            f" {self.scales.half_width:.3g} at the largest load and reaches |x| = {self.reach:.3g}"
            f" of {self.room:.3g}. This is an estimate by finite elements on a coarse mesh, one"
            f" revolution of {_STEPS_OF_ESTIMATE} increments; `halfplane run` solves the whole"
            " path."
        )


def estimate_room(scene: Scene, work_counts: Counter[str]) -> RoomForContact:
    """Quick estimate of the largest contact on bodies of finite size, and a check that their faces
    are wide enough for it.

    One cycle of a dozen increments is followed on a coarse mesh. A record of more than 16 rows of
    measured loads is shortened to the rows of extreme loads. The finely meshed part of the face is
    doubled in width until the contact does not touch its ends. `work_counts` counts condensations,
    the effort of the computation.

    Returns
    -------
    RoomForContact
        Largest distance from x = 0 at which the faces touch, half the width of the narrower face,
        and the scales of the contact.

    Raises
    ------
    InputError
        If the contact reaches past the end of the narrower face.
    """
    short_scene = _with_extreme_rows(scene)
    load_unit = largest_load(short_scene)
    if short_scene.load.states_approach:
        load_unit = _load_of_approach(short_scene, work_counts)
    modulus = contact_modulus(scene.material.lower, scene.material.upper)

    # The bodies on a coarse mesh; `largest_face_half_width`: 0.97 of the half-width of the narrower
    # face.
    coarse_bodies = _CoarseBodies(short_scene, load_unit, modulus, work_counts)
    face_half_width = _zone_half_width(coarse_bodies)
    while True:
        try:
            # _STEPS_OF_ESTIMATE: twelve increments
            problem, run = _coarse_run(
                coarse_bodies, face_half_width, steps=_STEPS_OF_ESTIMATE, cycles=1
            )
        except BesideTheFaces:  # the line of action of the loads misses the meshed faces
            if face_half_width == coarse_bodies.largest_face_half_width:
                raise
        else:
            if not _touches_an_end(run):
                scales = _scales_of_run(coarse_bodies, face_half_width, problem, run)
                return RoomForContact(scales.reach, least_face_half_width(scene), scales)
            if face_half_width == coarse_bodies.largest_face_half_width:
                raise _past_the_end(scene)
        # _FAR_ENLARGEMENT: twice the width
        face_half_width = min(
            face_half_width * _FAR_ENLARGEMENT, coarse_bodies.largest_face_half_width
        )


def _zone_half_width(coarse_bodies: _CoarseBodies) -> float:
    """Half-width [length] of the zone, the part of the face whose nodes may touch. At the largest
    load the contact reaches to 0.3 of it or more, but not to its end.

    The first trial is the half-width that suits half-planes. Each next one is twice the farthest
    |x| of the contact in the trial before. After ten trials the eleventh half-width is taken
    untried.

    The largest half-width, `largest_face_half_width`, is 0.97 of that of the narrower face. It is
    taken instead of any half-width of half of it or more; then the contact may reach to less than
    0.3 of it. InputError where all nodes of the largest zone touch in a trial.

    `coarse_bodies` are the bodies on a coarse mesh, with the largest load.
    """
    zone_half_width = min(
        _half_width_on_half_planes(coarse_bodies), coarse_bodies.largest_face_half_width
    )
    # _MOST_ENLARGEMENTS: ten trials
    for _ in range(_MOST_ENLARGEMENTS):
        # farthest |x| of the contact over that half-width; 1 where all nodes of the zone touch
        contact_fraction = _contact_fraction(coarse_bodies, zone_half_width)
        if contact_fraction == 1 and zone_half_width == coarse_bodies.largest_face_half_width:
            raise _past_the_end(coarse_bodies.scene)
        # _CONTACT_FRACTIONS[0]: 0.6; _FAR_ENLARGEMENT: factor 2, so that 0.3 is enough
        if _CONTACT_FRACTIONS[0] / _FAR_ENLARGEMENT <= contact_fraction < 1:
            break
        zone_half_width = min(
            contact_fraction * zone_half_width * _FAR_ENLARGEMENT,
            coarse_bodies.largest_face_half_width,
        )

    # From half of the largest zone on, the largest is taken at once: shear or tilt may move the
    # contact farther out.
    return (
        zone_half_width
        if zone_half_width * _FAR_ENLARGEMENT < coarse_bodies.largest_face_half_width
        else coarse_bodies.largest_face_half_width
    )


def _with_extreme_rows(scene: Scene) -> Scene:
    """Shorten a scene whose loads are a measured record of more than 16 rows (time, P, Q) to the
    rows of extreme loads: at one of them the contact is largest.

    The first and the last row stay, and the rows at which P, Q, Q/P, bulk stress or tilt is largest
    or smallest. Other scenes are returned unchanged.

    `optional_column_kinds` of the record names further columns: of bulk stress, tilt or moment.
    Each is one number, or a tuple with one for each row.
    """
    load_record = scene.load
    if not isinstance(load_record, TimeSeriesLoad) or len(load_record.kept_rows()) <= _MOST_ROWS:
        return scene

    # Rows (n, 3) that the load path goes through: with bulk stress or tilt all from the key
    # `start` to `end`, else those left after means and reduction. Further columns (n,) by name.
    first_row, row_beyond = load_record.row_bounds()
    rows_of_path = (
        load_record.rows.values[first_row:row_beyond]
        if load_record.has_bulk_or_tilt
        else load_record.kept_rows()
    )
    further_columns = {
        name: np.array(getattr(load_record, name)[first_row:row_beyond])
        for name in load_record.optional_column_kinds
        if isinstance(getattr(load_record, name), tuple)
    }

    # Numbers of the extreme rows of each column. For Q/P, P is at least 1e-6 of its largest value
    # (_LEAST_LOAD_RATIO).
    safe_normal_load = np.maximum(rows_of_path[:, 1], _LEAST_LOAD_RATIO * rows_of_path[:, 1].max())
    columns = [
        rows_of_path[:, 1],
        rows_of_path[:, 2],
        rows_of_path[:, 2] / safe_normal_load,
        *further_columns.values(),
    ]
    row_numbers = {0, len(rows_of_path) - 1}
    for column in columns:
        row_numbers |= {int(np.argmin(column)), int(np.argmax(column))}
    extreme_rows = sorted(row_numbers)
    short_record = TimeSeriesLoad(
        rows=rows_of_path[extreme_rows],
        repeats=load_record.repeats,
        **{name: tuple(column[extreme_rows].tolist()) for name, column in further_columns.items()},
        **{
            name: getattr(load_record, name)
            for name in load_record.optional_column_kinds
            if name not in further_columns and getattr(load_record, name) is not None
        },
    )
    return scene.model_copy(update={"load": short_record})


@dataclass(eq=False)
class _CoarseBodies:
    """The bodies on coarse meshes, for any half-width of the part of the face that may touch;
    half-planes are meshed once for all sizes.

    `load` is what they are pressed by [force per thickness], `modulus` E* [stress], `work_counts`
    counts of condensations. `largest_face_half_width` is that of the part that may touch [length].
    """

    scene: Scene
    load: float
    modulus: float
    work_counts: Counter[str]

    def __post_init__(self) -> None:
        self.largest_face_half_width = least_face_half_width(self.scene) * _SHARE_OF_FACE
        self._half_width_and_interface: tuple[float, Interface] | None = None

    def faces(self, face_half_width: float) -> Interface:
        """Contact compliance of the coarse bodies, whose nodes that may touch lie on |x| up to
        `face_half_width` [length]; in the scene's units.

        Half-planes are meshed once, with a half-width of 1: their compliance is the same at any
        half-width, and only places are scaled. Bodies of finite size are meshed for each one; the
        last mesh is cached. The error that the mesh adds between nearby nodes is taken out, where
        no base or end of a face is too near.
        """
        meshed_half_width = 1.0 if self.scene.bodies.half_planes else face_half_width
        if (
            self._half_width_and_interface is None
            or self._half_width_and_interface[0] != meshed_half_width
        ):
            # _COARSE_MESH: settings of the coarse mesh; `_grading`: element sizes along the face,
            # times `ratio`, that of the body
            meshed_bodies = meshed_pair(
                self.scene, _COARSE_MESH, lambda ratio: _grading(meshed_half_width, ratio)
            )
            meshed_interface = couple(
                *condensed_pair(self.scene, meshed_bodies, meshed_half_width, self.work_counts)
            )
            self._half_width_and_interface = (
                meshed_half_width,
                without_mesh_error(meshed_interface, self.scene) or meshed_interface,
            )
        interface = self._half_width_and_interface[1]
        if meshed_half_width == face_half_width:
            return interface
        return interface.scaled(meshed_half_width / face_half_width, 1.0)

    def problem(
        self,
        face_half_width: float,
        unscaled_interface: Interface,
        has_shear: bool,
        actuators: Actuators = LOADS_ARE_GIVEN,
    ) -> ContactProblem:
        """Scaled contact problem of the coarse bodies: lengths over `face_half_width`, forces over
        the largest load, compliances over 1/E*.

        Parameters
        ----------
        face_half_width
            half the width of the part of the face that may touch [length]
        unscaled_interface
            contact compliance of the bodies, in the scene's units
        has_shear
            whether friction is solved, else normal contact alone
        actuators
            which loads are prescribed as movements: none by default
        """
        interface = unscaled_interface.scaled(face_half_width, 1 / self.modulus)
        # displacements are over P/E*, P the largest load
        scaled_gap = initial_gap(self.scene, unscaled_interface) * self.modulus / self.load
        # compliances of a layer between the faces: 0, the exact contact law
        no_layer = Layer(np.zeros_like(unscaled_interface.x), np.zeros_like(unscaled_interface.x))
        return ContactProblem(
            interface,
            scaled_gap,
            self.scene.friction.coefficient,
            no_layer,
            has_shear=has_shear,
            has_given_moment=prescribed_path(self.scene).moment_is_given,
            actuators=actuators,
        )


def _grading(face_half_width: float, ratio: float) -> SurfaceGrading:
    """Element sizes of a coarse mesh along the face: 24 elements of one size, times `ratio`, on
    each side of x = 0 of the part that may touch, whose half-width is `face_half_width` [length].
    """
    return SurfaceGrading(
        inner=0.0,
        outer=face_half_width,
        size=ratio * face_half_width / _N_ELEMENTS,
        edge_size=ratio * face_half_width / _N_ELEMENTS,
        radius=5 * face_half_width,
    )


def _touches_an_end(run: PathRun) -> bool:
    """Whether the contact reached, at any instant of the run, the first or the last node of the
    part of the face that may touch.
    """
    return any(state.is_closed[0] or state.is_closed[-1] for state in run.states)


def _coarse_run(
    coarse_bodies: _CoarseBodies, face_half_width: float, steps: int, cycles: int = COARSE_CYCLES
) -> tuple[ContactProblem, PathRun]:
    """Solve a scene along its load path on a coarse mesh: the scaled contact problem, and the run,
    with the contact states along the path at all nodes.

    Where the solution is its own mirror image in x = 0, the nodes at x >= 0 alone are solved.

    Parameters
    ----------
    coarse_bodies
        the coarse bodies, with scene, largest load P and modulus E*
    face_half_width
        half the width of the part of the face that may touch [length]
    steps
        increments of a revolution
    cycles
        revolutions at most; two by default

    Raises
    ------
    ConvergenceError
        Where the run fails.
    """
    interface = coarse_bodies.faces(face_half_width)  # contact compliance, in the scene's units
    has_shear = needs_shear(coarse_bodies.scene)
    actuators = actuators_of(coarse_bodies.scene, face_half_width)
    problem = coarse_bodies.problem(face_half_width, interface, has_shear, actuators)
    is_halved = on_half(coarse_bodies.scene, interface)
    solved_problem = (
        coarse_bodies.problem(face_half_width, half_interface(interface), has_shear, actuators)
        if is_halved
        else problem
    )

    # Units of load, length and stress, and increments of a revolution; np.inf: any step error is
    # accepted.
    pace = Pace(coarse_bodies.load, steps, np.inf, face_half_width, coarse_bodies.modulus)
    # All states are stored, for their edges decide about the mesh; there are few nodes. Stick edges
    # are read off the nodes. Placing them between nodes by the loads would be of no use here.
    run = run_path(
        solved_problem,
        prescribed_path(coarse_bodies.scene),
        pace,
        cycles,
        lambda _step, _of_steps, _text: None,
        keep_all_states=True,
        places_stick_edges=False,
    )
    coarse_bodies.work_counts[UNPLACED_EDGES] += len(run.iterations)
    if run.failure is not None:
        raise run.failure
    return problem, run_at_all_nodes(run, interface) if is_halved else run


def _fitting_half_width(coarse_bodies: _CoarseBodies) -> float:
    """Half-width [length] of the part of the face to be meshed finely, so that the contact at the
    largest load takes 0.6 to 0.85 of it.

    It is tripled or divided by three until it is bracketed, then bisected in its logarithm. The
    narrower face limits it (`largest_face_half_width`). `coarse_bodies` are the bodies on a coarse
    mesh, with the largest load.

    Raises
    ------
    InputError
        Where the contact takes all of the narrower face, or no half-width is found.
    """
    too_small_size = 0.0
    too_large_size = np.inf
    face_half_width = min(
        _half_width_on_half_planes(coarse_bodies), coarse_bodies.largest_face_half_width
    )
    # Factors of 3, then bisection: more than 400 trials floating-point numbers do not allow.
    for _ in range(400):
        # farthest |x| of the contact over the half-width of the part of the face
        contact_fraction = _contact_fraction(coarse_bodies, face_half_width)
        # _CONTACT_FRACTIONS: 0.6 and 0.85
        if _CONTACT_FRACTIONS[0] <= contact_fraction <= _CONTACT_FRACTIONS[1]:
            return face_half_width

        if contact_fraction > _CONTACT_FRACTIONS[1]:
            if face_half_width == coarse_bodies.largest_face_half_width and contact_fraction < 1:
                return face_half_width
            if face_half_width == coarse_bodies.largest_face_half_width:
                raise _past_the_end(coarse_bodies.scene)
            too_small_size = face_half_width
            larger_size = (
                face_half_width * 3
                if np.isinf(too_large_size)
                else np.sqrt(too_small_size * too_large_size)
            )
            face_half_width = min(larger_size, coarse_bodies.largest_face_half_width)
        else:
            too_large_size = face_half_width
            face_half_width = (
                face_half_width / 3
                if too_small_size == 0
                else np.sqrt(too_small_size * too_large_size)
            )
    raise InputError(
        f"{coarse_bodies.scene.name}: no size of the bodies was found that holds the contact; check"
        " profile and loads"
    )


def _half_width_on_half_planes(coarse_bodies: _CoarseBodies) -> float:
    """First guess of the half-width [length] of the part of the face to be meshed finely: the one
    that suits the contact if both bodies were half-planes, which is cheap to find.

    Where they are half-planes, it is the datum length of the profile. `coarse_bodies` are
    the bodies on a coarse mesh.
    """
    if coarse_bodies.scene.bodies.half_planes:
        return coarse_bodies.scene.profile.datum_length
    half_planes = on_half_planes(coarse_bodies.scene, coarse_bodies.scene.profile.datum_length)
    return _fitting_half_width(
        _CoarseBodies(
            half_planes, coarse_bodies.load, coarse_bodies.modulus, coarse_bodies.work_counts
        )
    )


def _contact_fraction(coarse_bodies: _CoarseBodies, face_half_width: float) -> float:
    """Farthest |x| of a node that touches at the largest load without shear, over the half-width
    of the part of the face that may touch, `face_half_width` [length]; 1 where all nodes of that
    part touch.

    Where the contact is symmetric to x = 0 that |x| is its half-width, else more than that.
    `coarse_bodies` are the bodies on a coarse mesh.
    """
    problem, pressed_state = _pressed(coarse_bodies, face_half_width)
    if pressed_state.is_closed.all():
        return 1.0
    return float(np.abs(problem.interface.x[pressed_state.is_closed]).max())


def _pressed(
    coarse_bodies: _CoarseBodies, face_half_width: float
) -> tuple[ContactProblem, InterfaceState]:
    """Scaled contact problem of the coarse bodies without shear, and its state at the largest load.
    `face_half_width` is that of the part of the face that may touch [length].
    """
    interface = coarse_bodies.faces(face_half_width)
    solved_interface = (
        half_interface(interface) if on_half(coarse_bodies.scene, interface) else interface
    )
    problem = coarse_bodies.problem(face_half_width, solved_interface, has_shear=False)
    # equilibrium at the instant 0 under the scaled loads P = 1, Q = 0
    return problem, problem.equilibrium(problem.unloaded_state(), 0.0, (1.0, 0.0))[0]


def _past_the_end(scene: Scene) -> InputError:
    """Error to raise where the contact reaches past the end of the narrower face of a scene."""
    return InputError(
        "bodies: the contact at the largest load reaches past the end of the narrower face, at |x|"
        f" = {least_face_half_width(scene):.6g}: make the bodies wider, or the load less"
    )


def _innermost_edge(
    problem: ContactProblem,
    states: Sequence[InterfaceState],
    is_stuck: Mask,
    stick_may_be_anywhere: bool,
) -> float:
    """Least distance from x = 0 to which an edge of contact or of stick comes at some instants: in
    a symmetric contact the least half-width of either zone, 0 where nothing sticks; scaled.

    In an unsymmetric contact (`stick_may_be_anywhere`) it is 0 too where an edge crosses x = 0.

    Parameters
    ----------
    problem
        the contact problem, with places of its n nodes and length of face of each
    states
        contact states at the instants
    is_stuck
        (n_states, n) nodes that stick
    stick_may_be_anywhere
        whether the contact and its stick zone may lie beside x = 0
    """
    # Edges (n_states, 2) of the contact; of a symmetric one minus and plus its half-width.
    contact_zones = contact_edges_of_states(problem.interface, states)
    is_closed = np.stack([state.is_closed for state in states])
    signs_of_sides = np.array([-1.0, 1.0])
    if not stick_may_be_anywhere:
        contact_zones = np.diff(contact_zones) / 2 * signs_of_sides

    # Likewise of the stick zone; both edges are 0 where nothing sticks in a symmetric contact.
    stick_zones = stick_edges(
        problem.interface.x,
        is_stuck,
        is_closed,
        contact_zones,
        stick_may_be_anywhere=stick_may_be_anywhere,
    )
    if not stick_may_be_anywhere:
        stick_half_width = np.where(
            is_stuck.any(axis=1, keepdims=True), np.diff(stick_zones) / 2, 0.0
        )
        stick_zones = stick_half_width * signs_of_sides
    # Distances from x = 0, negative where an edge has crossed it; NaN (no edge) counts as 0.
    distances_from_middle = np.concatenate([contact_zones, stick_zones]) * signs_of_sides
    return max(float(np.nan_to_num(distances_from_middle).min()), 0.0)
