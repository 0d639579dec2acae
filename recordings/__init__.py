"""The paper's rig as data: rig.toml, model.toml and recordings."""
