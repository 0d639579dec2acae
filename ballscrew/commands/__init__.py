"""The commands, one file each.

In the order to read them: simulate, live, hub, review, report, fit, tune, compare, diagnose, suggest, improve, trend,
fleet, export, warm; those of a rig folder are in rig_folder/, those of effects in catalogue/.
"""
