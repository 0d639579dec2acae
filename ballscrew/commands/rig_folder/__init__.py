"""A rig folder, made and looked over: init, check."""
