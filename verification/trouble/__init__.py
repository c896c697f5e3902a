"""Runs that must not go wrong silently: files, signals, limits and restarts (here), and decks
(in `silent`).
"""
