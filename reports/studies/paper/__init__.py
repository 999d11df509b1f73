"""The paper again from half-plane theory: its figures, what it states in words, its misprints, and
the page of them all.
"""
