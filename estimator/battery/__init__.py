"""What every effect must pass: battery, bench, exercise."""
