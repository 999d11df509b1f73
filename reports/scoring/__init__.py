"""A result of another code: read into one form, put beside a reference, judged by the same metrics,
its likely faults named.

reading.py         which reader takes which file; tables of text (their numbers:
                   `scenes.text_tables.text_table`)
abaqus.py          reports of field output; reports of XY data are tables
fields.py          VTU, VTK and PVD; field_files.py, vtk_files.py: read by VTK in a process of
                   its own
calculix.py        CalculiX' results as tractions; calculix_files.py: the forms .frd and .dat
mapping.py         names of columns, factors of units, signs
surface.py         the one form; surface of a foreign mesh
history.py         which instant is which on the scene's load path
solution.py        units and signs that can't be; the result as a ContactSolution: states, edges,
                   friction work, by the same rule in the reference
against.py         the score
discrepancy.py     what is to be explained, and how much of it is noise
variants.py        half-plane theory with faults in it: tractions of a result with just these
causes.py          the causes, one object each: what it changes in theory, where its search starts
cells.py           contact on cells: faces with a layer between them, bodies that are not alike
evidence.py        what rows show before a cause is looked for: sums, points, laws, shape
traces.py          findings that rows show without theory: full slip, creep, scatter
other_problems.py  tractions of problems that the suite does not solve: signatures in the rows
fits.py            sizes of causes by least squares, what they leave, whether by chance
judgement.py       the order of evidence: pressure, then shear; which causes explain both
causes_in_words.py a cause in a sentence: what it is, how large, what to do
diagnosis.py       the findings in sentences, with their evidence and what is excluded
loops.py           a rig's loop of Q over U: the f that fits it, its interval, the engines' loops
loop_page.py       its page, JSON and table
loop_rows.py       its rows, read from a table
loop_branches.py   turning points of Q, the branch of each row
loop_steady_rows.py   which rows are of one steady loop, and why others are refused
loop_steadiness.py whether the cycles of a loop differ, and by chance or not
loop_masing.py     the loop at constant P by Masing's rule: partial and gross
loop_masing_fit.py f at constant P by least squares, and its interval
loop_fit.py        f by least squares where P varies: theory's whole loop
loop_over_time.py  f where Q has more turning points: rows are placed by their times
loop_fitted.py     what each of these fits gives
loop_theory.py     the scene's cycle: its loads, and U by either engine
loop_area.py       W of the rows, and its error
study.py           a folder of meshes: orders, and what no mesh removes
"""
