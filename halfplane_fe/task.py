"""What is to be solved: a scene, settings of meshes and solver, and the scales of its contact."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from functools import partial

from threadpoolctl import threadpool_limits

from halfplane_fe.resolution import tip_halvings
from halfplane_fe.scales import RoomForContact, Scales, estimate_room, is_plain_record
from halfplane_fe.settings import SolverSettings
from meshes import MeshSettings, SurfaceGrading, check
from scenes import Profile, Scene

# Least radius of a half-disc over the side that may touch: tilt can bring the contact far from x =
# 0.
_LEAST_RADIUS_RATIO = 1.5


@dataclass(frozen=True)
class Task:
    """What is to be solved: a scene, and how it is meshed, iterated and scaled.

    Attributes
    ----------
    scene
        bodies, materials, profile, friction and loads
    mesh
        settings of the meshes; element sizes are over the contact half-width
    settings
        of the contact solver and its increments
    scales
        by the run on a coarse mesh: contact half-width, places of edges, largest load, E*, friction
        work, and the values that the solution is compared with
    """

    scene: Scene
    mesh: MeshSettings
    settings: SolverSettings
    scales: Scales

    @property
    def has_errors_of_low_order(self) -> bool:
        """Whether linear elements or a penalty layer make errors that are not of order 2."""
        return self.mesh.order == 1 or self.settings.method == "penalty"

    @property
    def kinks_bound_step_error(self) -> bool:
        """Whether the friction work by kinks of pressure and slip, where nodes start to slide,
        bounds the error of the increments. So it is in records of like bodies, without bulk stress,
        tilt or penalty layer, with quadratic elements.
        """
        return is_plain_record(self.scene) and not self.has_errors_of_low_order

    @property
    def element_size(self) -> float:
        """Size of the elements at the edges of contact and stick, of the body with the larger ones,
        over the contact half-width.
        """
        return self.mesh.edge_element_size * max(self.mesh.upper_ratio, 1.0)

    @property
    def spacing(self) -> float:
        """Distance of the nodes at the edges of contact and stick [length]."""
        return self.element_size * self.scales.half_width / self.mesh.order

    @property
    def work_unit(self) -> float:
        """Unit of scaled friction work, P^2/E* with P the largest load [energy / thickness]."""
        return self.scales.load**2 / self.scales.modulus

    @property
    def friction_unit(self) -> float:
        """A f^2 P^2 over the unit P^2/E* of scaled work: 2 f^2.

        # notation: A = 2/E*, f coefficient of friction, P largest load
        """
        return 2 * self.scene.friction.coefficient**2


def surface_grading(
    mesh: MeshSettings, scales: Scales, profile: Profile, ratio: float = 1.0
) -> SurfaceGrading:
    """Element sizes along the face of a body: finest in the zone where edges of contact and stick
    travel, from just inside the innermost to just outside the outermost place that they reach.

    Where fewer than four of the larger elements fit between x = 0 and that zone, it begins at
    x = 0. A half-disc that stands for a half-plane gets its radius here too.

    Parameters
    ----------
    mesh
        settings; sizes are over the contact half-width a
    scales
        of a run on a coarse mesh: a, and the innermost and outermost place of an edge [length]
    profile
        initial gap; where it has a tip at x = 0, elements there are halved several times
    ratio
        factor on all sizes, of the upper body's elements over the lower one's
    """
    # a: contact half-width at the largest load. The coarse run gives edges to a few hundredths of
    # it: `scales.inner` and `scales.reach` are their innermost and outermost place.
    a = scales.half_width
    inner_end = scales.inner - 0.06 * a
    outer_end = scales.reach + 0.06 * a + 2 * mesh.edge_element_size * a
    # _LEAST_RADIUS_RATIO: the half-disc reaches to 1.5 of the outer end at least
    grading = SurfaceGrading(
        inner=inner_end if inner_end > 4 * mesh.element_size * a else 0.0,
        outer=outer_end,
        size=mesh.element_size * a * ratio,
        edge_size=mesh.edge_element_size * a * ratio,
        radius=max(mesh.far_radius * a, _LEAST_RADIUS_RATIO * outer_end),
        growth=mesh.growth,
    )
    return replace(grading, halvings=tip_halvings(profile, grading.size_at_middle))


def room_for_contact(scene: Scene, mesh: MeshSettings | None) -> RoomForContact:
    """Estimate of how far the contact reaches on the faces of bodies of finite size, by a run on a
    coarse mesh. Also a check that the bodies can be meshed finely enough for it.

    `mesh` are the settings of that fine mesh, None for the default ones. The estimate has the
    scales of the contact: half-width, load, and how far its edges reach.

    Raises
    ------
    InputError
        For a face too narrow for the contact, or a body that can't be meshed so finely.
    ConvergenceError
        Where the coarse run does not converge.
    """
    settings = mesh or MeshSettings()
    with threadpool_limits(limits=1, user_api="blas"):
        estimate = estimate_room(scene, Counter())  # counts of the work are not reported
    # sizes of the elements along the face, as a function of a factor on them
    grading = partial(surface_grading, settings, estimate.scales, scene.profile)
    check("lower", scene.bodies.lower, scene.profile, grading(1.0), settings)
    check("upper", scene.bodies.upper, scene.profile, grading(settings.upper_ratio), settings)
    return estimate
