"""Error against run time: contacts, time steps, the mean drag, replicates."""
