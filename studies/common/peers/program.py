"""Codes that are programs of their own: whether one is there, and what it prints."""

import shutil
import subprocess


def absent(program: str) -> str | None:
    """None if a program can be used, else one sentence that says why not."""
    return None if shutil.which(program) else f"there is no program {program}."


def output(*command: str, folder=None, text: str = "") -> str:
    """What a program prints for an input; errors too, which some put in the last lines or nowhere."""
    run = subprocess.run(
        command,
        cwd=folder,
        input=text,
        text=True,
        check=False,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    return run.stdout


def last_lines(text: str) -> str:
    """The end of what a program has printed, on one line."""
    return " ".join(text.split("\n")[-3:])
