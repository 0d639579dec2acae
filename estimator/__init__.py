"""Physics and statistics of a heated screw: no clock, thread, plot or print in here.

In the order to read them: record, cover, screw, rig, rig_log, terms, effect, model, filter, step, errors, work.
"""
