"""How far an estimate or a prediction is from what was measured.

In the order to read them: accuracy, review, machine, doubts, compare, horizon, blind, quality, displacement,
reference, polyline, noise_floor.
"""
