"""The files of the study of accuracy: one a job, and accuracy.nc with all of them."""

from dem.studies.accuracy.layout import VARIABLES
from dem.sweep.study import Study

MAKERS = tuple(f"dem.studies.accuracy.{name}" for name in ("contacts", "steps", "runs"))
STUDY = Study("error against run time", "dem accuracy", VARIABLES, ("trial", "replicate"), MAKERS)
