"""Other codes that run the same scenes: LAMMPS, LIGGGHTS and YADE, where they are installed."""
