"""The commands, one file each.

In the order to read them: simulate, live, hub, review, report, fit, tune, compare, diagnose, suggest, improve, export,
show, effects, add, new_effect.
"""
