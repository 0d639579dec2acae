"""Every frame of a bus, on the disk: recorder, part, folder_lock."""
