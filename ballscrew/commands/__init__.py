"""The commands, one file each.

In the order to read them: init, check, simulate, live, hub, review, report, fit, tune, compare, diagnose, suggest,
improve, trend, fleet, export, show, effects, add, new_effect, warm.
"""
