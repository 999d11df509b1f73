"""How wrong is half-plane theory for your contact? Both solutions of one scene, their comparison
and its page, from one import.

A scene of the library, solved by half-plane theory and by plane-strain finite elements of the real
bodies; the difference with its uncertainty::

    import halfplane

    scene = halfplane.load_scene("blocks")
    fe = halfplane.finite_elements(scene)
    theory = halfplane.theory(scene, x=fe.x, time=fe.time)
    effects = halfplane.body_effects(scene)  # theory's displacements count from the supports then
    comparison = halfplane.compare(reference=theory, result=fe, effects=effects)
    print(comparison.summary())
    halfplane.report(comparison, "out/blocks")

The names and what they are::

    Scene            the question: bodies, materials, profile, friction, loads (`scenes.Scene`)
    load_scene       a scene from the library or a file (`scenes.load_scene`)
    theory           half-plane theory (`semi_analytic.solve`)
    finite_elements  plane-strain finite elements (`halfplane_fe.solve`)
    body_effects     what finite bodies add to half-planes, no contact solved
                     (`halfplane_fe.body_effects`)
    advise           how far theory errs for these bodies, and why, no contact solved
                     (`reports.advising.advise`)
    compare          one solution against the other (`reports.compare`)
    report           the page and its files (`reports.write`)

All else is in five packages: `from halfplane.scenes import Block, Bodies`, likewise
`halfplane.semi_analytic`, `halfplane.meshes`, `halfplane.halfplane_fe` and `halfplane.reports`.
`import halfplane` is cheap: a name is loaded when it is first used. `python -m halfplane` is the
command `halfplane`.

Examples
--------
>>> import halfplane
>>> scene = halfplane.load_scene("cattaneo-mindlin")
>>> theory = halfplane.theory(scene)
>>> halfplane.compare(reference=theory, result=theory).metric("dissipation").value
0.0
>>> scene.vary(friction=0.6).friction.coefficient
0.6
"""

from __future__ import annotations

from halfplane import package_names

TYPE_CHECKING = False  # as in `typing`, whose import takes longer than this module
if TYPE_CHECKING:
    from typing import Any

    from halfplane_fe import body_effects
    from halfplane_fe import solve as finite_elements
    from reports import compare
    from reports import write as report
    from reports.advising import advise
    from scenes import Scene, load_scene
    from semi_analytic import solve as theory

__all__ = [
    "Scene",
    "advise",
    "body_effects",
    "compare",
    "finite_elements",
    "load_scene",
    "report",
    "theory",
]

_HOME = {
    "Scene": ("scenes", "Scene"),
    "advise": ("reports.advising", "advise"),
    "body_effects": ("halfplane_fe", "body_effects"),
    "compare": ("reports", "compare"),
    "finite_elements": ("halfplane_fe", "solve"),
    "load_scene": ("scenes", "load_scene"),
    "report": ("reports", "write"),
    "theory": ("semi_analytic", "solve"),
}

package_names.install()


def __getattr__(name: str) -> Any:
    """Value of an attribute of this package that is loaded when it is first used: the version, a
    package, or a function or class of one of them.

    Raises
    ------
    AttributeError
        For an unknown name.
    """
    from importlib import import_module

    if name == "__version__":
        from importlib.metadata import version

        return version("halfplane")
    if name in package_names.PACKAGES:
        return import_module(f"{__name__}.{name}")
    if name not in _HOME:
        raise AttributeError(f"module 'halfplane' has no attribute {name!r}")
    # `_HOME`: for each public name its package, and its name there.
    package, name_in_package = _HOME[name]
    value = getattr(import_module(f"{__name__}.{package}"), name_in_package)
    _show_scenes_and_solutions(import_module(f"{__name__}.scenes.notebook_forms"))
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)


def _show_scenes_and_solutions(notebook_forms: Any) -> None:
    """Give scenes and solutions their HTML and figures; what draws is loaded when it first does."""
    from functools import partial

    if notebook_forms.registered_forms() is None:
        names = ("scene_html", "solution_html", "solution_figure", "loop_figure")
        functions = {name: partial(_draw, name) for name in names}
        notebook_forms.register(notebook_forms.NotebookForms(**functions))


def _draw(name: str, *shown: Any) -> Any:
    """What the notebook function called `name` makes of the scenes or solutions `shown`; its module
    is imported when it is first used.
    """
    from importlib import import_module

    return getattr(import_module(f"{__name__}.reports.page.notebook"), name)(*shown)
