"""A rig folder from recordings of a rig that nobody has described: `ballscrew init`.

In the order to read them: new_rig, seen, bus_log, lab_table, words, temperatures, drive, growth, scan, geometry,
rig_file, model_file.
"""
