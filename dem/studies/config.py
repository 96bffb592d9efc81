"""A configuration file as the workflow reads it: the sweep, and the sections of the studies."""

from pathlib import Path

from pydantic import model_validator

from dem.base.yaml_file import read
from dem.experiment import config
from dem.studies.accuracy.plan import AccuracySection
from dem.studies.claims.plan import ClaimsSection


class Sweep(config.Sweep):
    """A whole configuration file."""

    accuracy: AccuracySection | None = None  # error against run time
    claims: ClaimsSection | None = None  # which of the paper's claims hold

    @model_validator(mode="after")
    def _check_studies(self):
        for study in (self.accuracy, self.claims):
            if study:
                study.check(self)
        return self


def parse(data, source: str = "configuration") -> Sweep:
    """Sweep from the content of a file; raises InputError with one sentence a fault."""
    return config.parse(data, source, Sweep)


def load(path: Path) -> Sweep:
    """Sweep from a YAML file; raises InputError with one sentence a fault."""
    return parse(read(path), str(path))
