"""Commands that no verb can follow."""

RUN = "simulate --config config/smoke.yaml --shape c1 --density 3900 --seed 1 -o OUT"
COMBINE = "combine --config config/smoke.yaml -o OUT"
OF_A_RUN = {
    "--density -1": "density is -1.0",
    "--seed -4": "seed is -4",
    "--seed 2147483648": "seed is 2147483648",
    "--seed 9223372036854775808": "seed is 9223372036854775808",
    "--config config/none.yaml": "config/none.yaml",
    "gravity": "'gravity' is no value; write PATH=VALUE",
    "gravty=1": "the nearest is gravity",
    "shape=d1": "write --shape d1",
    "--shape C1": "the nearest is c1",
    "box_width=8mm": "it must be a number, in m",
    "gravity=1,2,3": "it must be a number, in m s-2",
    "cylinder.speed=1": "cylinder.speed is no value that can vary; the nearest is cylinder.",
    "record.window=[1,2]": "record.window is no value that can vary",
}
COMMANDS = {f"{RUN} {words}": sentence for words, sentence in OF_A_RUN.items()} | {
    f"{COMBINE} --block drg": "block is 'drg'; the sweep has no such block; the nearest is drag",
    f"{COMBINE} --observable zz": "observable is 'zz'",
    "figure figure13 pyproject.toml": "pyproject.toml",
    "figure 13 config/smoke.yaml -o OUT": "there are figure07, figure08",
    "figure figure07 docs/data/flow.nc -o OUT": "it holds no drag, and figure07 is drawn from that",
    "figure figure09 docs/data/drag.nc -o OUT": "figure09 is drawn from that; name snapshots.nc.",
    "figure figure07 docs/data/drag.nc --of drag -o OUT": "only the figure sweep shows another",
    "figure all docs/data/flow.nc -o OUT": "it holds nothing that a figure shows; name drag.nc.",
    "figure sweep studies/onset/onset.nc --of drag -o OUT": "it has no drag; it has onset_fraction",
    "draw docs/data/drag.nc point=0 -o OUT.png": "no value named point; they differ in case",
    "info config/smoke.yaml": "it is not a readable netCDF file",
    "sweep config/smok.yaml": "cannot read it ([Errno 2] No such file or directory: 'config/smok.",
    "report studies/shear/shear.nc -o OUT.html": "there are no figures; draw them first",
}
