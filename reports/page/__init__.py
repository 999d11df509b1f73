"""The page of a comparison, its folder and figures, and the page of a rig.

The page and its folder (writing.py), the view of the last cycle that its figures share
(cycle_view.py), figures over x (field_figures.py), over time and load (history_figures.py), of the
error budget (budget_figures.py) and of the bodies (body_figures.py), comparison.json (content.py),
what a notebook shows (notebook.py), and the page of a scene that prescribes displacements (rig.py).

Offered to the rest of reports: `write` `figure` `as_json` `whole_content`; `published`, the picture
of a published scene; `RigMotion`, what a rig does; `fit_residuals`, trace, fit and residuals of a
profile.
"""
