"""Where rig and model part, and whether the estimate is to be trusted: alarms, window, trust."""
