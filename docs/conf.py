"""Sphinx settings: Markdown pages, furo theme. `make docs` builds them and takes every warning as
an error.
"""

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

project = "halfplane"
author = "the halfplane authors"
project_copyright = "the halfplane authors, GPL-3.0-or-later"
version = release = installed_version("halfplane")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    # beside this file: formulas as MathML, signs in docstrings, published pages
    "sphinx_parts",
]
# The source beside the reference: a quarter of the time, and nothing that a check looks at.
if not tags.has("check"):  # noqa: F821 (Sphinx gives it)
    extensions.append("sphinx.ext.viewcode")
exclude_patterns = ["_build"]

myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "fieldlist", "colon_fence"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
autodoc_type_aliases = {
    name: name
    for name in ("Array", "ArrayLike", "Integers", "Profile", "LoadPath", "Shape", "Table")
}
autodoc_default_options = {"exclude-members": "model_config, model_post_init"}
default_role = "code"  # `name` in a docstring
napoleon_google_docstring = False
napoleon_use_ivar = True  # attributes as a list, not as entries of their own
python_maximum_signature_line_length = 100
viewcode_line_numbers = True

html_theme = "furo"
html_title = f"halfplane {release}"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_show_sphinx = False
