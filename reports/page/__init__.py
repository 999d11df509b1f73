"""The page with its figures, and its folder (writing.py), comparison.json (content.py), and what a
notebook shows (notebook.py).

Offered to the rest of reports: `write` `figure` `as_json` `whole_content`, and `published`, the
picture of a published scene.
"""
