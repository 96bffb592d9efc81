"""Commands in this process."""

from typer.testing import CliRunner

from dem.cli.app import app


def called(line, app=app):
    """What a line of words for `dem`, or for another application, did."""
    return CliRunner().invoke(app, line.split())
