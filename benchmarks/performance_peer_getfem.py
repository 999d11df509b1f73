"""Press and shear two bodies by GetFEM: runs in an interpreter that has it (Debian's python3-getfem), not in ours.

    python3 performance_peer_getfem.py QUESTION.npz ANSWER.npz

The question holds both bodies' nodes, elements and held nodes, E, nu, f and the loads; the answer p and q on the lower face.
"""

import sys
import time

import numpy as np

begun = time.process_time()
import getfem as gf  # noqa: E402

imported, begun = time.process_time() - begun, time.process_time()
gf.util_trace_level(0)
asked = np.load(sys.argv[1])
CONTACT, HELD = 1, 2


# by hand
def mesh_of(body):
    mesh = gf.Mesh("empty", 2)
    corners = asked[body + "_nodes"][asked[body + "_elements"]][:, [0, 1, 3, 2]]
    mesh.add_convex(gf.GeoTrans("GT_QK(2,1)"), np.transpose(corners, (2, 1, 0)))
    for region, nodes in ((CONTACT, "_contact"), (HELD, "_held")):
        mesh.set_region(region, mesh.faces_from_pid(mesh.pid_from_coords(asked[body + nodes].T)))
    return mesh


model, young, poisson, friction = gf.Model("real"), *asked["numbers"][:3]
normal, tangential = asked["normal"], asked["tangential"]
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
    model.add_isotropic_linearized_elasticity_brick(methods[body], "u_" + body, "lame", "rigidity")
model.add_Dirichlet_condition_with_multipliers(methods["lower"], "u_lower", 1, HELD)
model.add_variable("plane", 2)
model.add_filtered_fem_variable("hold", fields["upper"], HELD)
model.add_linear_term(methods["upper"], "hold.(Test_u_upper - Test_plane) + Test_hold.(u_upper - plane)", HELD)
force = model.add_explicit_rhs("plane", np.zeros(2))
model.add_filtered_fem_variable("traction", fields["lower"], CONTACT)
for name, value in (("r", young * 10), ("f", friction), ("alpha", 1.0)):
    model.add_initialized_data(name, value)
for body in meshes:
    model.add_fem_data("old_" + body, fields[body])
brick = model.add_integral_large_sliding_contact_brick_raytracing("r", 0.1, "f", "alpha", 0)
model.add_slave_contact_boundary_to_large_sliding_contact_brick(
    brick, methods["lower"], CONTACT, "u_lower", "traction", "old_lower"
)
model.add_master_contact_boundary_to_large_sliding_contact_brick(brick, methods["upper"], CONTACT, "u_upper", "old_upper")
guess = np.array([0.0, -asked["numbers"][3]])
model.set_variable("plane", guess)
model.set_variable("u_upper", np.tile(guess, fields["upper"].nbdof() // 2))
iterations = 0
for load in zip(tangential, -normal, strict=True):
    model.set_private_rhs(force, np.array(load))
    done = model.solve("max_res", 1e-10, "max_iter", 60, "lsearch", "simplest")
    iterations += int(done[1] if isinstance(done, tuple) else done)
    for body in meshes:
        model.set_variable("old_" + body, model.variable("u_" + body))
# so far
places = fields["lower"].basic_dof_nodes()[:, fields["lower"].basic_dof_on_region(CONTACT)][0, ::2]
traction = model.variable("traction").reshape(-1, 2)
seconds = time.process_time() - begun
answer = {"x": places, "q": traction[:, 0], "p": -traction[:, 1], "iterations": iterations}
np.savez(sys.argv[2], seconds=seconds, imported=imported, **answer)
