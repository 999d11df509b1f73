"""A third opinion: the scene as an input deck for CalculiX and Abaqus, and CalculiX' own answer beside the two engines'."""
