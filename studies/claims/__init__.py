"""Which of the paper's claims hold, and why: more runs, other assumptions, jamming, scaling."""

IRREGULARITY = {  # of how irregularly beds move, as dem.experiment.observables.flow names them
    "non_affine": "non-affine motion (D2min)",
    "fluctuation": "motion apart from the neighbours",
    "mixing": "mixing",
    "contacts_lost": "contacts lost",
}
