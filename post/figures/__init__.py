"""The figures of the paper, drawn from committed results: `python -m post.figures.section4`."""
