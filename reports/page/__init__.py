"""The page with its figures, and its folder (writing.py), and what a notebook shows (notebook.py).

Offered to the rest of reports: `write` `figure`, and `published`, the picture of a published scene.
"""
