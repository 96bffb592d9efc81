"""python -m dem: the command line of the package that this Python finds."""

from dem.cli.app import app

if __name__ == "__main__":
    app(prog_name="dem")
