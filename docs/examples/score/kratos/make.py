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
from typing import Any, NamedTuple

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


class Block(NamedTuple):
    """A keyword of a deck with its parameters, and its data lines as numbers."""

    keyword: str
    parameters: dict[str, str]
    rows: list[list[float]]


@dataclass(frozen=True)
class Deck:
    """What the deck says."""

    blocks: list[Block]

    def all(self, keyword: str, **parameters: str) -> list[list[list[float]]]:
        """Data lines of every block of that keyword and those parameters."""
        return [
            block.rows
            for block in self.blocks
            if block.keyword == keyword and parameters.items() <= block.parameters.items()
        ]

    def first(self, keyword: str, **parameters: str) -> list[list[float]]:
        """Data lines of the first of them."""
        return self.all(keyword, **parameters)[0]

    def amplitude(self, name: str) -> np.ndarray:
        """(n, 2) times and values."""
        rows = self.first("AMPLITUDE", NAME=name)
        return np.array([number for row in rows for number in row]).reshape(-1, 2)


def read_deck(path: Path) -> Deck:
    """Keywords and numbers of a deck; sides S1 to S4 become 1 to 4."""
    blocks: list[Block] = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            keyword, *words = (word.strip() for word in line[1:].split(","))
            parameters = dict(word.split("=", 1) for word in words if "=" in word)
            blocks.append(Block(keyword, parameters, []))
        elif blocks[-1].keyword not in WORDS_ONLY:
            numbers = [float(word.strip().lstrip("S")) for word in line.split(",") if word.strip()]
            blocks[-1].rows.append(numbers)
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
    project = {
        "problem_data": problem,
        "solver_settings": solver,
        "processes": {"contact_process_list": [process]},
    }
    return Kratos.Parameters(json.dumps(project))


def fill(part: Kratos.ModelPart, deck: Deck) -> None:
    """Both bodies: nodes, elements, material, and the faces as conditions whose normals point
    outwards.
    """
    for number, body in enumerate(("LOWER", "UPPER"), 1):
        properties = part.CreateNewProperties(number)
        elastic_of_body = deck.all("ELASTIC")[number - 1]
        young_modulus, poisson_ratio = elastic_of_body[0]
        properties[Kratos.YOUNG_MODULUS] = young_modulus
        properties[Kratos.POISSON_RATIO] = poisson_ratio
        properties[Kratos.THICKNESS] = 1.0
        properties[Kratos.CONSTITUTIVE_LAW] = Kratos.KratosGlobals.GetConstitutiveLaw(
            "LinearElasticPlaneStrain2DLaw"
        ).Clone()
        body_part = part.CreateSubModelPart(body)
        for node, x, y, _ in deck.first("NODE", NSET=f"{body}_NODES"):
            body_part.CreateNewNode(int(node), x, y, 0.0)
        elements = {}
        for element, *corners in deck.first("ELEMENT", ELSET=body):
            elements[int(element)] = list(map(int, corners))
        for element, corners in elements.items():
            body_part.CreateNewElement("SmallDisplacementElement2D4N", element, corners, properties)
        face = part.CreateSubModelPart(f"{body}_FACE")
        for element, side in deck.first("SURFACE", NAME=f"{body}_FACE"):
            ends = [elements[int(element)][corner] for corner in SIDES[int(side) - 1]]
            face.AddNodes(ends)
            face.CreateNewCondition(
                "LineCondition2D2N", part.NumberOfConditions() + 1, ends, properties
            )


class History(StructuralMechanicsAnalysis):
    """The touch, then every instant of the deck."""

    def __init__(self, deck: Deck) -> None:
        self.deck = deck
        self.rows = []
        normal = deck.amplitude("NORMAL_LOAD")
        tangential = deck.amplitude("TANGENTIAL_LOAD")
        self.loads = np.column_stack([normal, tangential[:, 1]])
        self.step = 0
        self.current_loads = (0.0, 0.0)
        friction = deck.first("FRICTION")[0][0]
        super().__init__(Kratos.Model(), settings(friction, float(normal[-1, 0])))
        self.part = self.model["Structure"]
        fill(self.part, deck)
        # Nodes of the upper arc: the second lines of the equations. The first one carries the loads
        # and leads the others.
        equations = [row for rows in deck.all("EQUATION") for row in rows]
        arc = sorted({int(row[0]) for row in equations if len(row) > 1})
        self.leader = self.part.GetNode(arc[0])
        self.followers = [self.part.GetNode(node) for node in arc[1:]]
        number = self.part.NumberOfConditions() + 1
        self.load = self.part.CreateNewCondition(
            "PointLoadCondition2D1N", number, [arc[0]], self.part.GetProperties(2)
        )

    def ModifyInitialGeometry(self) -> None:
        """What holds the lower body, and the rigid plane behind the upper one."""
        for node, direction in self.deck.first("BOUNDARY"):
            self.part.GetNode(int(node)).Fix(DIRECTIONS[int(direction) - 1])
        kind = "LinearMasterSlaveConstraint"
        number = 0
        for node in self.followers:
            for along in DIRECTIONS:
                number += 1
                self.part.CreateNewMasterSlaveConstraint(
                    kind, number, self.leader, along, node, along, 1.0, 0.0
                )

    def KeepAdvancingSolutionLoop(self) -> bool:
        """Whether an instant of the deck is left."""
        return self.step < len(self.loads)

    def _AdvanceTime(self) -> float:
        """Step 0 is the touch, a prescribed approach; step k > 0 has the loads of instant k."""
        if self.step == 0:
            current_time = self.deck.first("STATIC")[0][1]
            approach = self.deck.all("BOUNDARY")[1][1][3]
        else:
            current_time, *self.current_loads = self.loads[self.step].tolist()
        self.part.CloneTimeStep(current_time)
        self.part.ProcessInfo[Kratos.STEP] += 1
        for along in DIRECTIONS:
            (self.leader.Fix if self.step == 0 else self.leader.Free)(along)
        if self.step == 0:
            self.leader.SetSolutionStepValue(Kratos.DISPLACEMENT_Y, approach)
        normal, tangential = self.current_loads
        self.load.SetValue(Structure.POINT_LOAD, [tangential, -normal, 0.0])
        return current_time

    def SolveSolutionStep(self) -> bool:
        """RuntimeError where the increment does not converge."""
        if not super().SolveSolutionStep():
            normal, tangential = self.current_loads
            raise RuntimeError(
                f"Kratos did not converge at instant {self.step}, P = {normal:.6g}, Q ="
                f" {tangential:.6g}"
            )
        return True

    def OutputSolutionStep(self) -> None:
        """Traction on the lower face: the multipliers, times the scale that Kratos gave them."""
        if self.step > 0:
            lower = self.face_nodes("LOWER")
            x, lower_displacement = displacement_along_x(lower)
            upper_x, upper_displacement = displacement_along_x(self.face_nodes("UPPER"))
            multipliers = [
                node.GetSolutionStepValue(Kratos.VECTOR_LAGRANGE_MULTIPLIER) for node in lower
            ]
            scale = self.part.ProcessInfo[Kratos.SCALE_FACTOR]
            traction = scale * np.array(list(map(list, multipliers)))
            slip = np.interp(x, upper_x, upper_displacement) - lower_displacement
            for k in range(len(x)):
                pressure = 0.0 - traction[k, 1]
                shear = traction[k, 0]
                self.rows.append((self.step, *self.current_loads, x[k], pressure, shear, slip[k]))
        self.step += 1

    def face_nodes(self, body: str) -> list[Any]:
        """Nodes of a body's face from left to right."""
        return sorted(self.part.GetSubModelPart(f"{body}_FACE").Nodes, key=lambda node: node.X0)


def displacement_along_x(nodes: list[Any]) -> tuple[np.ndarray, np.ndarray]:
    """(n,) undeformed places of nodes along x, and how far each moved along it."""
    places = np.array([node.X0 for node in nodes])
    displacements = [node.GetSolutionStepValue(Kratos.DISPLACEMENT_X) for node in nodes]
    return places, np.array(displacements)


def main(deck: Path, table: Path) -> None:
    """Solve, write the table, and beside it what made it."""
    run = History(read_deck(deck))
    start = time.process_time()
    run.Run()
    seconds = time.process_time() - start
    lines = [",".join(NAMES)]
    for step, *values in run.rows:
        x = values[NAMES.index("x") - 1]
        if abs(x) < 2.5:
            numbers = [f"{value:.7g}" for value in values]
            lines.append(",".join([str(step), *numbers]))
    table.write_text("\n".join(lines) + "\n", encoding="utf-8")
    origin = {
        "code": f"Kratos {version('KratosMultiphysics')}",
        "seconds": round(seconds, 1),
        "increments": len(run.loads),
    }
    table.with_name("made.json").write_text(json.dumps(origin) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
