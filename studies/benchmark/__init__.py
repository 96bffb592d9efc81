"""Time and motion of this code beside those of others: on the same bed, with the same time step."""
