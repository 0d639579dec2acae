"""What measures it, with its errors: telemeter, probes, jig, environment, drive, truth."""
