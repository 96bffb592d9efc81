"""Commands that no verb can follow."""

OF_A_RUN = {
    "--density inf": "density is inf",
    "--seed 2147483648": "seed is 2147483648",
    "--config config/none.yaml": "config/none.yaml",
    "--checkpoint README.md": "README.md",
    "gravity": "'gravity' is no value; write PATH=VALUE",
    "gravty=1": "the nearest is gravity",
    "shape=d1": "write --shape d1",
    "--shape C1": "the nearest is c1",
    "box_width=8mm": "it must be a number, in m",
    "cylinder.speed=1": "cylinder.speed is not a value that can vary; the nearest is cylinder.",
    "record.window=[1,2]": "record.window is not a value that can vary",
}
COMMANDS = {
    f"simulate --config config/smoke.yaml --shape c1 --density 3900 --seed 1 -o OUT {words}": sentence
    for words, sentence in OF_A_RUN.items()
} | {
    "combine --config config/smoke.yaml -o OUT --block drg": "not one of the blocks; the nearest is drag",
    "combine --config config/smoke.yaml -o OUT --observable zz": "observable is 'zz'",
    "figure figure13 pyproject.toml": "pyproject.toml",
    "figure all docs/data/drag.nc -o README.md": "output is 'README.md/all.svg'; it must be in a folder",
    "figure 13 config/smoke.yaml -o OUT": "there are figure07, figure08",
    "figure figure07 docs/data/flow.nc -o OUT": "it holds no drag, and figure07 is drawn from that",
    "figure velocity docs/data/drag.nc -o OUT": "shows 4 values of cylinder_velocity",
    "figure figure07 docs/data/drag.nc --of drag -o OUT": "only the figure sweep shows another",
    "figure all docs/data/flow.nc -o OUT": "it holds nothing that a figure shows; name drag.nc.",
    "figure sweep docs/data/drag.nc --of lift -o OUT": "it has no lift; it has ",
    "draw docs/data/scene.nc seed=1 --at 0.5 -o OUT.mp4": "at is 0.5 and output ",
    "info config/smoke.yaml": "it is not a readable netCDF file",
    "sweep config/smok.yaml": "cannot read it ([Errno 2] No such file or directory: 'config/smok.",
}
