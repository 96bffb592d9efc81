"""What varies in a sweep, and cannot."""

A_LABEL = (
    "it must be a label: a letter from A to Z, then letters, digits, - and _, at most 32 in all."
)
POINTS = {"design": "sobol", "points": 4}
GRAVITY, GRAVIT = ({name: {"low": 0, "high": 1}} for name in ("gravity", "gravit"))
DERIVED = {"packing.fraction": {"derive": "equal_load", "friction": 0.3}}
C1 = {"shape": "c1"}
# one key of the paper's sweep, or all that varies: a part of the sentence about it
KEYS = [
    ("cases", {}, "sweep must give all runs a shape or a case; there are c1, d1"),
    ("sweep.seed", 1.5, "sweep.seed is 1.5; it must be a whole number."),
    ("sweep.seed", [1, 2, 1], "sweep.seed has 1 twice; list each once."),
    ("sweep.seed", [], "sweep.seed is []; it must be a list of values."),
    ("sweep.seed", "1 to 100000", "sweep has 1,100,000 runs; it must have at most 1,000,000."),
    ("sweep.friction/granule", [0.3, 0.1 + 0.2], "sweep.friction.granule has 0.3 twice; list each"),
    ("sweep.friction/granule", [0, -0.0], "twice; list each once"),
    ("sweep.case", ["c1", "c13"], "is 'c13', which is not one of cases; the nearest is c1."),
    ("sweep.density", [1e3], "sweep varies density in two ways; name it once."),
    ("sweep.gravity", {"time": [1]}, "it must be a list of values, or factors: {times: [0.5, 2]}."),
    ("sweep.gravity", {"times": ["x"]}, "sweep.gravity is 'x'; it must be a number."),
    ("sweep.numerics/allow_unstable", {"times": [2]}, "is false, which has no multiples."),
    ("sweep.friction_granule", [0.1], "no value that can vary; the nearest is friction.granule."),
    ("sweep.record/window", [[0, 1]], "no value that can vary; the nearest is record.bins."),
    ("sweep.cylinder/stroke", [1e-3], "varies cylinder.stroke, which runs of one block share"),
    ("sweep.cylinder/start", [0.25, 0.01], "asks for an impossible run"),
    ("sweep.p", {"a": {"gravity": 1}, "b": 3}, "sweep: p is no value that can vary"),
    ("sweep.p", {"a": {"gravity": [1, 2]}}, "sweep.p.a.gravity is [1, 2]; it must be a number"),
    ("sweep.p", {"a": {"density": 0.0}}, "sweep.p.a.density is 0.0; it must be positive"),
    ("sweep.p", {1: {}, "1": {}}, "has '1' twice"),
    ("sweep.m n", {"a": {"gravity": 1}}, f"a name in sweep is 'm n'; {A_LABEL}"),
    ("sweep.p", POINTS | {"over": GRAVITY, "design": "grid"}, "sweep.p.design is 'grid'; it must"),
    ("sweep.p", POINTS | {"over": GRAVIT}, "the nearest is gravity"),
    ("sweep.p", POINTS | {"points": 12, "over": GRAVITY}, "is a power of two: take 8 or 16."),
    ("sweep.p", POINTS | {"over": {"gravity": {"low": 0, "high": 1, "scale": "log"}}},
     "low is 0; on a log scale it must be above 0."),
    ("sweep", {"box": {"a": C1, "b": {"gravity": 1}}}, "sweep must give all runs a shape or a case"),
    ("sweep", {"blocks": {}}, "sweep.blocks is {}; it must have at least 1 item"),
    ("sweep", {"blocks": {"../x": {"case": "all"}}}, f"sweep.blocks.../x is '../x'; {A_LABEL}"),
    ("sweep", {"blocks": {"store": {"case": "all"}}}, "sweep.blocks.store is a folder of results"),
    ("sweep", {"blocks": {"a": 3}}, "sweep.blocks.a is 3; it must be a group of keys."),
    ("sweep", {"blocks": {"a": {None: [1]}}}, "sweep.blocks.a: null is no value that can vary"),
    ("sweep", {"blocks": {"a": {"needs": "b"}}}, "it must be a block before it: there is none."),
    ("sweep", {"blocks": {"a": C1, "b": C1 | {"needs": "a", "s": {"x": DERIVED}}}}, "leave friction"),
    ("sweep", {"blocks": {"a": C1}} | C1, "has blocks and shape"),
    ("sweep", C1 | {"friction.wall": [1], "friction_wall": {"a": {}}}, "two things named friction_w"),
    *(("sweep.seed", words, "sweep.seed") for words in
      ["5 to 1", "1 to", "one to two", "1 to 99999999999", "1, 1", "", "-1 to 3", "2147483648"]),
]  # fmt: skip
FILES = {f"{key} {value} {words}": ({key: value}, words) for key, value, words in KEYS}
