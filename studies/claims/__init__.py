"""Which of the paper's claims hold, and why: more runs, other assumptions, jamming, scaling."""

IRREGULARITY = {  # of how irregularly beds move, as dem.experiment.observables.flow names them
    "non_affine": "non-affine displacement",
    "fluctuation": "motion apart from the neighbours",
    "mixing": "mixing of layers",
    "contacts_lost": "contacts lost",
}
