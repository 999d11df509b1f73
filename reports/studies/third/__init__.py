"""Third solver: the scene as an input deck for CalculiX, and CalculiX' answer beside those of the
two engines.
"""
