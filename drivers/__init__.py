"""Where samples come from and where estimates go: logs, live buses, the virtual rig."""
