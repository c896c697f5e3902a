"""The paper's figures, each drawn from committed results by one module: `python -m
post.figures.section4`.
"""
