"""What varies in a sweep, and cannot."""

A_LABEL = (
    "it must be a label: a letter from A to Z, then letters, digits, - and _, at most 32 in all."
)
POINTS = {"design": "sobol", "points": 4}
RANGE = {"low": 0, "high": 1}
C1 = {"shape": "c1"}
B = {"gravity": 1}


def derived(value=(), **varied):
    wanted = C1 | {"packing.fraction": {"derive": "equal_load"} | dict(value)}
    grown = C1 | {"experiment": "jamming"}
    return {
        "sweep": {
            "blocks": {"a": {"values": grown}, "b": {"needs": "a", "values": wanted} | varied}
        }
    }


# one key of the paper's sweep, or all that varies
FILES = {
    "sweep.seed is []; it must be a list of values.": {"sweep.seed": []},
    "sweep has 1,100,000 runs; it must have at most 1,000,000.": {"sweep.seed": "1 to 100000"},
    "sweep.friction.granule has 0.3 twice": {"sweep.friction/granule": [0.3, 0.1 + 0.2]},
    "twice; list each once": {"sweep.friction/granule": [0, -0.0]},
    "is 'c13', which is not one of cases; the nearest is c1.": {"sweep.case": ["c1", "c13"]},
    "sweep varies density in two ways; name it once.": {"sweep.density": [1e3]},
    "it must be a list of values, or factors: {times: [0.5, 2]}.": {"sweep.gravity": {"time": [1]}},
    "is false, which has no multiples.": {"sweep.numerics/allow_unstable": {"times": [2]}},
    "a value that can vary; the nearest is friction.granule.": {"sweep.friction_granule": [0.1]},
    "varies cylinder.stroke, which runs of one block share": {"sweep.cylinder/stroke": [1e-3]},
    "asks for an impossible run": {"sweep.cylinder/start": [0.25, 0.01]},
    "sweep: p is not a value that can vary": {"sweep.p": {"a": B, "b": 3}},
    "sweep.p.a.gravity is [1, 2]; it must be a number": {"sweep.p": {"a": {"gravity": [1, 2]}}},
    "has '1' twice": {"sweep.p": {1: {}, "1": {}}},
    f"a name in sweep is 'm n'; {A_LABEL}": {"sweep.m n": {"a": B}},
    "sweep.p has a point without a name; give it one": {"sweep.p": {" ": B}},
    "not a value that can vary; the nearest is gravity": {
        "sweep.p": POINTS | {"over": {"gravit": RANGE}}
    },
    "is a power of two: take 8 or 16.": {
        "sweep.p": POINTS | {"points": 12, "over": {"gravity": RANGE}}
    },
    "low is 0; on a log scale it must be above 0.": {
        "sweep.p": POINTS | {"over": {"gravity": RANGE | {"scale": "log"}}}
    },
    "sweep must give all runs a shape or a case": {"sweep": {"box": {"a": C1, "b": B}}},
    f"sweep.blocks.../x is '../x'; {A_LABEL}": {"sweep": {"blocks": {"../x": {"case": "all"}}}},
    "blocks.store is a folder of results": {"sweep": {"blocks": {"store": {"case": "all"}}}},
    "blocks.a: null is not a value that can vary": {"sweep": {"blocks": {"a": {None: [1]}}}},
    "needs is 'b'; it must be a block before it: a.": derived(needs="b"),
    "leave friction out": derived({"friction": 0.3}),
    "contact.law 'linear'; loads of jamming compare under": derived() | {"contact.law": "linear"},
    "has the shape 'z9'": derived({"shape": "z9"}),
    "values.packing.fraction derives a value; needs must name": derived(needs=[]),
    "'load', which is not one of those that blocks in needs give; there are equal_di": derived(
        {"derive": "load"}
    ),
    "seed has until, and needs a; list the seeds": derived(seed={"until": "5 %"}),
    "has blocks and shape": {"sweep": {"blocks": {"a": C1}} | C1},
    "uses the name friction_w": {"sweep": C1 | {"friction.wall": [1], "friction_wall": {"a": {}}}},
} | {
    f"sweep.seed is {seeds!r}": {"sweep.seed": seeds}
    for seeds in ["5 to 1", "1 to 99999999999", "-1 to 3", "2147483648"]
}
