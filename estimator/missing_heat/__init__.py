"""Where and when heat is missing, and which readings are wrong."""
