"""A bus: who listens, who shares it, who sends: bus, receiver, rig_time, stamp, missing, publisher, hub."""
