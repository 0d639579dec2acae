"""Every frame of a bus, on the disk, and what an earlier one left there: recorder, part, folder_lock, earlier."""
