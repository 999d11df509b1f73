"""The page: what it shows (content.py), and the folder that it is written into with its data (writing.py)."""
