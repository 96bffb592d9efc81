"""Other codes that run the same scenes: LAMMPS and LIGGGHTS, where they are installed."""
