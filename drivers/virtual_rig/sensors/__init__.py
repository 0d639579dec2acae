"""What measures it, with its errors."""
