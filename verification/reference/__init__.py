"""A second implementation of three problems of the paper, dense and slow, with numpy only.

    .venv/bin/python -m verification.reference section4|hemisphere|strip|all [--compare build/release/bezel]

It follows the paper (Corbett and Sauer 2015, whose equation numbers are used) and, where the paper
is silent, the verification pages. It shares no code with the program. Read the modules in this
order:

spline       B-splines in one direction
mesh         hexahedral patches of splines
layer        enriched layers
solid        neo-Hooke and enhanced strains
system       all unknowns in one dense matrix, Newton's iteration, steps
surface      contact surfaces and the closest-point projection
contact      two half passes: penalty, friction, debonding
section4     the cube of section 4
hemisphere   sections 5.2 and 5.3
strip        the first lift of section 5.1
__main__     tables of the results, on request beside those of the program
"""
