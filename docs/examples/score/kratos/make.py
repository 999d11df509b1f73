"""The scene of an exported CalculiX deck, solved by Kratos: dual mortar contact, augmented
Lagrangian, Coulomb friction.

    python make.py DECK.inp RESULT.csv

Everything is taken from the deck that `halfplane export SCENE` writes: nodes, elements, faces,
materials, friction, supports, the touch, and the loads at every instant. It needs numpy and the
wheels of Kratos, and nothing of halfplane.
"""

from __future__ import annotations

import json
import sys
import time
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import KratosMultiphysics as Kratos
import KratosMultiphysics.ContactStructuralMechanicsApplication
import KratosMultiphysics.StructuralMechanicsApplication as Structure
import numpy as np
from KratosMultiphysics.StructuralMechanicsApplication.structural_mechanics_analysis import (
    StructuralMechanicsAnalysis,
)

# Corners of the sides S1 to S4 of a CPE4 element.
SIDES = ((0, 1), (1, 2), (2, 3), (3, 0))
DIRECTIONS = (Kratos.DISPLACEMENT_X, Kratos.DISPLACEMENT_Y)
WORDS_ONLY = ("HEADING", "CONTACT PAIR", "CONTACT FILE", "CONTACT PRINT", "NODE PRINT")
NAMES = ("step", "normal_load", "tangential_load", "x", "pressure", "shear", "slip")


@dataclass(frozen=True)
class Deck:
    """What the deck says: `blocks` are (keyword, parameters, data lines of numbers)."""

    blocks: list[tuple[str, dict[str, str], list[list[float]]]]

    def all(self, keyword: str, **wanted: str) -> list[list[list[float]]]:
        """Data lines of every block of that keyword and those parameters."""
        return [
            data
            for word, given, data in self.blocks
            if word == keyword and wanted.items() <= given.items()
        ]

    def one(self, keyword: str, **wanted: str) -> list[list[float]]:
        """Data lines of the first of them."""
        return self.all(keyword, **wanted)[0]

    def amplitude(self, name: str) -> np.ndarray:
        """(n, 2) times and values."""
        return np.array(
            [number for row in self.one("AMPLITUDE", NAME=name) for number in row]
        ).reshape(-1, 2)


def read_deck(path: Path) -> Deck:
    """Keywords and numbers of a deck; sides S1 to S4 become 1 to 4."""
    blocks: list[tuple[str, dict[str, str], list[list[float]]]] = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            words = [word.strip() for word in line[1:].split(",")]
            blocks.append(
                (words[0], dict(word.split("=", 1) for word in words[1:] if "=" in word), [])
            )
        elif blocks[-1][0] not in WORDS_ONLY:
            blocks[-1][2].append(
                [float(word.strip().lstrip("S")) for word in line.split(",") if word.strip()]
            )
    return Deck(blocks)


def settings(friction: float, end: float) -> Kratos.Parameters:
    """The project's parameters: Kratos' own defaults but for what stands here."""
    contact = {
        "model_part_name": "Structure",
        "contact_model_part": {"0": ["LOWER_FACE", "UPPER_FACE"]},
        "assume_master_slave": {"0": ["LOWER_FACE"]},
        "friction_coefficients": {"0": friction},
        "contact_type": "Frictional",
    }
    solver = {
        "solver_type": "Static",
        "model_part_name": "Structure",
        "domain_size": 2,
        "model_import_settings": {"input_type": "use_input_model_part"},
        "time_stepping": {"time_step": 1.0},
        # The equations of the rigid plane and the multipliers together are more than the mixed
        # solver condenses.
        "contact_settings": {"mortar_type": "ALMContactFrictional", "use_mixed_ulm_solver": False},
        "buffer_size": 3,
        "convergence_criterion": "contact_residual_criterion",
        "max_iteration": 40,
        "linear_solver_settings": {"solver_type": "LinearSolversApplication.sparse_lu"},
    }
    process = {
        "python_module": "alm_contact_process",
        "kratos_module": "KratosMultiphysics.ContactStructuralMechanicsApplication",
        "process_name": "ALMContactProcess",
        "Parameters": contact,
    }
    problem = {
        "problem_name": "halfplane",
        "parallel_type": "OpenMP",
        "start_time": 0.0,
        "end_time": end,
        "echo_level": 0,
    }
    whole = {
        "problem_data": problem,
        "solver_settings": solver,
        "processes": {"contact_process_list": [process]},
    }
    return Kratos.Parameters(json.dumps(whole))


def fill(part: Kratos.ModelPart, deck: Deck) -> None:
    """Both bodies: nodes, elements, material, and the faces as conditions whose normals point
    outwards.
    """
    for number, body in enumerate(("LOWER", "UPPER"), 1):
        properties = part.CreateNewProperties(number)
        properties[Kratos.YOUNG_MODULUS], properties[Kratos.POISSON_RATIO] = deck.all("ELASTIC")[
            number - 1
        ][0]
        properties[Kratos.THICKNESS] = 1.0
        properties[Kratos.CONSTITUTIVE_LAW] = Kratos.KratosGlobals.GetConstitutiveLaw(
            "LinearElasticPlaneStrain2DLaw"
        ).Clone()
        whole = part.CreateSubModelPart(body)
        for node, x, y, _ in deck.one("NODE", NSET=f"{body}_NODES"):
            whole.CreateNewNode(int(node), x, y, 0.0)
        elements = {
            int(row[0]): [int(node) for node in row[1:]] for row in deck.one("ELEMENT", ELSET=body)
        }
        for element, corners in elements.items():
            whole.CreateNewElement("SmallDisplacementElement2D4N", element, corners, properties)
        face = part.CreateSubModelPart(f"{body}_FACE")
        for element, side in deck.one("SURFACE", NAME=f"{body}_FACE"):
            ends = [elements[int(element)][corner] for corner in SIDES[int(side) - 1]]
            face.AddNodes(ends)
            face.CreateNewCondition(
                "LineCondition2D2N", part.NumberOfConditions() + 1, ends, properties
            )


class History(StructuralMechanicsAnalysis):
    """The touch, then every instant of the deck."""

    def __init__(self, deck: Deck) -> None:
        self.deck, self.rows = deck, []
        normal, tangential = deck.amplitude("NORMAL_LOAD"), deck.amplitude("TANGENTIAL_LOAD")
        self.loads = np.column_stack([normal, tangential[:, 1]])
        self.done, self.now = 0, (0.0, 0.0)
        friction = deck.one("FRICTION")[0][0]
        super().__init__(Kratos.Model(), settings(friction, float(normal[-1, 0])))
        self.part = self.model["Structure"]
        fill(self.part, deck)
        # Nodes of the upper arc: the second lines of the equations. The first one carries the loads
        # and leads the others.
        arc = sorted({int(row[0]) for data in deck.all("EQUATION") for row in data if len(row) > 1})
        self.leader, self.followers = (
            self.part.GetNode(arc[0]),
            [self.part.GetNode(node) for node in arc[1:]],
        )
        new = self.part.NumberOfConditions() + 1
        self.load = self.part.CreateNewCondition(
            "PointLoadCondition2D1N", new, [arc[0]], self.part.GetProperties(2)
        )

    def ModifyInitialGeometry(self) -> None:
        """What holds the lower body, and the rigid plane behind the upper one."""
        for node, direction in self.deck.one("BOUNDARY"):
            self.part.GetNode(int(node)).Fix(DIRECTIONS[int(direction) - 1])
        kind, number = "LinearMasterSlaveConstraint", 0
        for node in self.followers:
            for along in DIRECTIONS:
                number += 1
                self.part.CreateNewMasterSlaveConstraint(
                    kind, number, self.leader, along, node, along, 1.0, 0.0
                )

    def KeepAdvancingSolutionLoop(self) -> bool:
        return self.done < len(self.loads)

    def _AdvanceTime(self) -> float:
        """Step 0 is the touch, a prescribed approach; step k > 0 has the loads of instant k."""
        if self.done == 0:
            now, down = self.deck.one("STATIC")[0][1], self.deck.all("BOUNDARY")[1][1][3]
        else:
            now, *self.now = self.loads[self.done].tolist()
        self.part.CloneTimeStep(now)
        self.part.ProcessInfo[Kratos.STEP] += 1
        for along in DIRECTIONS:
            (self.leader.Fix if self.done == 0 else self.leader.Free)(along)
        if self.done == 0:
            self.leader.SetSolutionStepValue(Kratos.DISPLACEMENT_Y, down)
        self.load.SetValue(Structure.POINT_LOAD, [self.now[1], -self.now[0], 0.0])
        return now

    def SolveSolutionStep(self) -> bool:
        if not super().SolveSolutionStep():
            raise RuntimeError(
                f"Kratos did not converge at instant {self.done}, P = {self.now[0]:.6g}, Q ="
                f" {self.now[1]:.6g}"
            )
        return True

    def OutputSolutionStep(self) -> None:
        """Traction on the lower face: the multipliers, times the scale that Kratos gave them."""
        if self.done > 0:
            lower, upper = (
                sorted(self.part.GetSubModelPart(f"{body}_FACE").Nodes, key=lambda n: n.X0)
                for body in ("LOWER", "UPPER")
            )
            scale = self.part.ProcessInfo[Kratos.SCALE_FACTOR]
            x, over = np.array([node.X0 for node in lower]), np.array([node.X0 for node in upper])
            traction = scale * np.array(
                [[*node.GetSolutionStepValue(Kratos.VECTOR_LAGRANGE_MULTIPLIER)] for node in lower]
            )
            moved = [
                np.array([node.GetSolutionStepValue(Kratos.DISPLACEMENT_X) for node in face])
                for face in (lower, upper)
            ]
            slip = np.interp(x, over, moved[1]) - moved[0]
            for k in range(len(x)):
                self.rows.append(
                    (self.done, *self.now, x[k], 0.0 - traction[k, 1], traction[k, 0], slip[k])
                )
        self.done += 1


def main(deck: Path, result: Path) -> None:
    """Solve, write the table, and beside it what made it."""
    run, begun = History(read_deck(deck)), time.process_time()
    run.Run()
    seconds = time.process_time() - begun
    near = [row for row in run.rows if abs(row[3]) < 2.5]
    lines = [
        ",".join(NAMES),
        *(f"{row[0]}," + ",".join(f"{value:.7g}" for value in row[1:]) for row in near),
    ]
    result.write_text("\n".join(lines) + "\n", encoding="utf-8")
    made = {
        "code": f"Kratos {version('KratosMultiphysics')}",
        "seconds": round(seconds, 1),
        "increments": len(run.loads),
    }
    result.with_name("made.json").write_text(json.dumps(made) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
