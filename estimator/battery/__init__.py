"""What every effect must pass: battery, bench, exercise; and admitted, what is asked each time that it is used."""
