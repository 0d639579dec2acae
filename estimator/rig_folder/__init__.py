"""A folder that describes an installation: rig.toml, model.toml, and effects of one's own."""
