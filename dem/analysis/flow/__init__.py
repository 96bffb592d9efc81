"""How a bed moves: its snapshots, measures of them, pictures and films."""
