"""How beds move: the motion of a replicate, measures of it, flow.nc."""
