"""Other people's codes on our questions: runs in an interpreter that has the code (`make peers`, or
Debian's), not in ours.

    python peer_codes.py CODE QUESTION.npz ANSWER.npz      CODE: tamaas, contactmechanics or getfem

Between "by hand" and "so far" stands what a user writes; its lines are counted on the page of
performance.
"""

import sys
import time

import numpy as np


def tamaas(question):
    """Hertz line contact, periodic, by Polonsky and Keer."""
    import tamaas

    begun = time.process_time()
    # by hand: tamaas
    n = int(question["points"])
    period = float(question["period"])
    x = (np.arange(n) + 0.5) * period / n - period / 2
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_1d, [period], [n])
    model.E = float(question["modulus"])
    model.nu = 0.0
    solver = tamaas.PolonskyKeerRey(model, -(x**2) / (2 * float(question["radius"])), 1e-12)
    solver.max_iter = 10_000
    solver.solve(float(question["load"]) / period)
    pressure = np.array(model.traction).ravel()
    # so far
    return {"x": x, "p": pressure, "seconds": time.process_time() - begun}


def contactmechanics(question):
    """Hertz line contact, periodic."""
    from ContactMechanics import PeriodicFFTElasticHalfSpace
    from ContactMechanics.Systems import NonSmoothContactSystem
    from SurfaceTopography import UniformLineScan

    begun = time.process_time()
    # by hand: contactmechanics
    n = int(question["points"])
    period = float(question["period"])
    x = (np.arange(n) + 0.5) * period / n - period / 2
    surface = UniformLineScan(-(x**2) / (2 * float(question["radius"])), period, periodic=True)
    system = NonSmoothContactSystem(
        PeriodicFFTElasticHalfSpace((n,), float(question["modulus"]), (period,)), surface=surface
    )
    minimum = system.minimize_proxy(external_force=float(question["load"]), pentol=1e-12)
    pressure = minimum.jac * n / period
    # so far
    spent = time.process_time() - begun
    if not minimum.success:
        sys.exit(minimum.message)
    return {"x": x, "p": pressure, "seconds": spent}


def getfem(question):
    """Press and shear two bodies: nodes, elements, held nodes, E, nu, f and the loads are given; p
    and q on the lower face.
    """
    import getfem as gf

    begun = time.process_time()
    gf.util_trace_level(0)
    contact = 1
    held = 2

    # by hand: getfem
    def mesh_of(body):
        mesh = gf.Mesh("empty", 2)
        corners = question[body + "_nodes"][question[body + "_elements"]][:, [0, 1, 3, 2]]
        mesh.add_convex(gf.GeoTrans("GT_QK(2,1)"), np.transpose(corners, (2, 1, 0)))
        for region, nodes in ((contact, "_contact"), (held, "_held")):
            mesh.set_region(
                region, mesh.faces_from_pid(mesh.pid_from_coords(question[body + nodes].T))
            )
        return mesh

    model = gf.Model("real")
    young, poisson, friction, _ = question["numbers"]
    normal = question["normal"]
    tangential = question["tangential"]
    meshes = {body: mesh_of(body) for body in ("lower", "upper")}
    rule = gf.Integ("IM_GAUSS_PARALLELEPIPED(2,4)")
    methods = {body: gf.MeshIm(mesh, rule) for body, mesh in meshes.items()}
    fields = {}
    for body, mesh in meshes.items():
        fields[body] = gf.MeshFem(mesh, 2)
        fields[body].set_classical_fem(1)
        model.add_fem_variable("u_" + body, fields[body])
    model.add_initialized_data("lame", young * poisson / (1 + poisson) / (1 - 2 * poisson))
    model.add_initialized_data("rigidity", young / 2 / (1 + poisson))
    for body in meshes:
        model.add_isotropic_linearized_elasticity_brick(
            methods[body], "u_" + body, "lame", "rigidity"
        )
    model.add_Dirichlet_condition_with_multipliers(methods["lower"], "u_lower", 1, held)
    model.add_variable("plane", 2)
    model.add_filtered_fem_variable("hold", fields["upper"], held)
    model.add_linear_term(
        methods["upper"], "hold.(Test_u_upper - Test_plane) + Test_hold.(u_upper - plane)", held
    )
    force = model.add_explicit_rhs("plane", np.zeros(2))
    model.add_filtered_fem_variable("traction", fields["lower"], contact)
    for name, value in (("r", young * 10), ("f", friction), ("alpha", 1.0)):
        model.add_initialized_data(name, value)
    for body in meshes:
        model.add_fem_data("old_" + body, fields[body])
    brick = model.add_integral_large_sliding_contact_brick_raytracing("r", 0.1, "f", "alpha", 0)
    add_slave = model.add_slave_contact_boundary_to_large_sliding_contact_brick
    add_slave(brick, methods["lower"], contact, "u_lower", "traction", "old_lower")
    add_master = model.add_master_contact_boundary_to_large_sliding_contact_brick
    add_master(brick, methods["upper"], contact, "u_upper", "old_upper")
    guess = np.array([0.0, -question["numbers"][3]])
    model.set_variable("plane", guess)
    model.set_variable("u_upper", np.tile(guess, fields["upper"].nbdof() // 2))
    for load in zip(tangential, -normal, strict=True):
        model.set_private_rhs(force, np.array(load))
        model.solve("max_res", 1e-10, "max_iter", 60, "lsearch", "simplest")
        for body in meshes:
            model.set_variable("old_" + body, model.variable("u_" + body))
    # so far
    places = fields["lower"].basic_dof_nodes()[:, fields["lower"].basic_dof_on_region(contact)][
        0, ::2
    ]
    traction = model.variable("traction").reshape(-1, 2)
    return {
        "x": places,
        "q": traction[:, 0],
        "p": -traction[:, 1],
        "seconds": time.process_time() - begun,
    }


if __name__ == "__main__":
    code, question, answer = sys.argv[1:]
    solve = {"tamaas": tamaas, "contactmechanics": contactmechanics, "getfem": getfem}[code]
    np.savez(answer, **solve(np.load(question)))
