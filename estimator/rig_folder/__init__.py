"""A folder that describes an installation: rig.toml, model.toml, and effects of one's own.

In the order to read them: rig_folder, model_toml, fields, bounds, contradictions.
"""
