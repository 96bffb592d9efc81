"""How beds move: the motion of a replicate, measures of it, verdicts on them, flow.nc."""
