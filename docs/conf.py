"""Sphinx settings: Markdown pages, furo theme. `make docs` builds them and takes every warning as an error."""

from importlib.metadata import version as installed_version

project = "halfplane"
author = "the halfplane authors"
project_copyright = "the halfplane authors, GPL-3.0-or-later"
version = release = installed_version("halfplane")

extensions = ["myst_parser"]
myst_enable_extensions = ["dollarmath", "deflist", "fieldlist"]
myst_heading_anchors = 3
exclude_patterns = ["_build"]
html_theme = "furo"
html_title = f"halfplane {release}"
