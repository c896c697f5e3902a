"""Endurance test: hostile inputs, kills, signals, limits and other units, drawn from a seed.

    .venv/bin/python -m verification.soak --minutes 60 --seed 1     (make soak MINUTES=60 SEED=1)

launch    one call of the program, and what is wrong with it
fuzz      mutations of decks, of the files they read, and of checkpoints
minimise  the smallest text that still fails
trials    the kinds of trials, and the list of decks that are killed
decks     small decks (friction, cohesion, inertia, arc length) with units as parameters
"""
