"""Names under which programs write a column, in English, German, French, Italian and Spanish."""

from __future__ import annotations

import unicodedata

# Compared by `normalised_name`: without case, accents, blanks and what stands in brackets.
# Languages stand in the order English, German, French, Italian, Spanish; no word has two meanings
# in them.
ALIASES: dict[str, tuple[str, ...]] = {
    "time": (
        "time",
        "t",
        "step time",
        "total time",
        "time value",
        "steptime",
        "totaltime",
        "elapsed time",
        "elapsed",
        "running time",
        "test time",
        "timestamp",
        "X_Value",  # LabVIEW
        "Zeit",
        "Zeitstempel",
        "Uhrzeit",
        "Messzeit",
        "Versuchszeit",
        "temps",
        "horodatage",
        "tempo",
        "tiempo",
    ),
    "frame": ("frame", "increment", "inc", "step", "Inkrement"),
    "normal_load": (
        "normal_load",
        "P",
        "normal force",
        "Fn",
        "RF2",
        "load",
        "normal",
        "contact force",
        "clamping force",
        "vertical force",
        "vertical load",
        "Normalkraft",
        "Normallast",
        "Anpresskraft",
        "Kontaktkraft",
        "Vertikalkraft",
        "effort normal",
        "force normale",
        "charge normale",
        "force de contact",
        "forza normale",
        "carico normale",
        "forza di contatto",
        "fuerza normal",
        "carga normal",
        "fuerza de contacto",
    ),
    "tangential_load": (
        "tangential_load",
        "Q",
        "tangential force",
        "shear force",
        "shear load",
        "Ft",
        "RF1",
        "friction force",
        "tangential",
        "lateral force",
        "lateral load",
        "Tangentialkraft",
        "Querkraft",
        "Reibkraft",
        "Reibungskraft",
        "Schubkraft",
        "effort tangentiel",
        "force tangentielle",
        "charge tangentielle",
        "force de frottement",
        "forza tangenziale",
        "carico tangenziale",
        "forza di attrito",
        "forza d'attrito",
        "fuerza tangencial",
        "carga tangencial",
        "fuerza de fricción",
        "fuerza de rozamiento",
    ),
    "x": (
        "x",
        "X",
        "COORD1",
        "COOR1",
        "X coordinate",
        "true distance",
        "distance",
        "points:0",
        "point x",
        "position",
        "lateral position",
        "lateral",
        "Abstand",
        "abscisse",
        "posizione",
        "posición",
    ),
    "y": ("y", "Y", "COORD2", "COOR2", "Y coordinate", "points:1", "point y"),
    "pressure": (
        "pressure",
        "p",
        "CPRESS",
        "contact_pressure",
        "normal_contact_stress",
        "Kontaktdruck",
        "Kontaktpressung",
        "pression de contact",
        "pressione di contatto",
        "presión de contacto",
    ),
    "shear": (
        "shear",
        "q",
        "CSHEAR1",
        "CSHEAR",
        "tangential_contact_stress",
        "contact_shear",
        "shear traction",
        "traction",
        "Schubspannung",
        "Kontaktschub",
        "cisaillement",
        "tensione tangenziale",
        "tensión tangencial",
    ),
    "slip": (
        "slip",
        "s",
        "CSLIP1",
        "CSLIP",
        "tangential_slip",
        "relative_slip",
        "Schlupf",
        "Gleitweg",
        "glissement",
        "scorrimento",
        "deslizamiento",
    ),
    "displacement": (
        "U",
        "displacement",
        "tangential_displacement",
        "relative displacement",
        "lateral displacement",
        "stroke",
        "Verschiebung",
        "Relativverschiebung",
        "Tangentialverschiebung",
        "Weg",
        "déplacement",
        "déplacement relatif",
        "déplacement tangentiel",
        "spostamento",
        "spostamento relativo",
        "spostamento tangenziale",
        "desplazamiento",
        "desplazamiento relativo",
        "desplazamiento tangencial",
    ),
    "approach": (
        "approach",
        "normal_approach",
        "indentation",
        "Annäherung",
        "rapprochement",
        "avvicinamento",
        "acercamiento",
    ),
    "height": (
        "h",
        "height",
        "gap",
        "z",
        "profile",
        "profile height",
        "Höhe",
        "Profilhöhe",
        "hauteur",
        "altezza",
        "altura",
    ),
}
# Of the columns that a scene asks for.
_ALIAS_KEYS_OF_SCENE_COLUMNS = {
    "P": "normal_load",
    "Q": "tangential_load",
    "U": "displacement",
    "h": "height",
}


def aliases_of(column: str) -> tuple[str, ...]:
    """The names of a column that a scene asks for, its own first.

    >>> aliases_of("Q")[:2]
    ('Q', 'tangential_load')
    """
    return (column, *ALIASES[_ALIAS_KEYS_OF_SCENE_COLUMNS.get(column, column)])


def normalised_name(name: str) -> str:
    """The name of a column up to its first "[" or "(", where a unit begins, in lower-case letters
    and digits alone: spellings of one name then compare equal.

    Accents, blanks, underscores and other signs go. A single letter keeps its case: P is a load and
    p a pressure. A colon stays: "points:0" is a name of x.

    >>> (
    ...     normalised_name(" Contact_Pressure [MPa]"),
    ...     normalised_name("CSHEAR1 (top)"),
    ...     normalised_name("P [N/mm]"),
    ... )
    ('contactpressure', 'cshear1', 'P')
    >>> normalised_name("Déplacement (mm)"), normalised_name("Höhe")
    ('deplacement', 'hohe')
    """
    name_before_unit = name.split("[", maxsplit=1)[0].split("(", maxsplit=1)[0]
    # NFKD parts an accent from its letter.
    name_of_letters = "".join(
        character
        for character in unicodedata.normalize("NFKD", name_before_unit)
        if character.isalnum() or character == ":"
    )
    # A single letter keeps its case.
    return name_of_letters if len(name_of_letters) == 1 else name_of_letters.lower()
