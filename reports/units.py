"""Units and numbers as the page and the terminal write them."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenes import Scene


def units(scene: Scene) -> tuple[str, str, str]:
    """Names of force, length and stress."""
    return scene.unit_words


def load_unit(scene: Scene) -> str:
    """Unit of a load per thickness.

    >>> from scenes import load_scene
    >>> load_unit(load_scene("hertz-paper"))
    'N/mm'
    """
    force, length, _ = units(scene)
    return f"{force}/{length}"


def energy_unit(scene: Scene) -> str:
    """Unit of an energy per thickness.

    >>> from scenes import load_scene
    >>> energy_unit(load_scene("hertz-paper"))
    'N·mm/mm'
    """
    force, length, _ = units(scene)
    return f"{force}·{length}/{length}"


def signed(value: float) -> str:
    """Four significant digits, with a minus sign that is one.

    >>> signed(-0.28273), signed(0.5)
    ('−0.2827', '0.5')
    """
    return minus(f"{value:.4g}")


def number(value: float) -> str:
    """Six significant digits, with a minus sign that is one.

    >>> number(90.62286500739786), number(-210e3)
    ('90.6229', '−210000')
    """
    return minus(f"{value:.6g}")


def minus(figure: str) -> str:
    """A figure as Python prints it, with minus signs for hyphens.

    >>> minus("-2.0e-06"), minus("8.6")
    ('−2.0e−06', '8.6')
    """
    return figure.replace("-", "−")
