"""A bus, who listens, shares, sends: bus, kernel_buffer, receiver, age, rig_time, missing, publisher, hub."""
