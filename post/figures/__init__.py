"""Figures of doc/verification, drawn from committed results: `python -m post.figures.section4`."""
