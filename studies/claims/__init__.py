"""Which of the paper's claims hold, and why: more runs, other assumptions, jamming, scaling."""
