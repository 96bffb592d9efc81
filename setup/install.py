"""Install what a lock lists into the environment of this Python: python setup/install.py LOCK.

uv needs seconds where pip needs a minute. pip fetches uv from the lock beside this script, and
installs everything itself if uv fails. `--editable DIRECTORY` instead of LOCK installs a checkout.
"""

import ast
import importlib.util
import os
import subprocess
import sys
from pathlib import Path

PIP = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
UV = [sys.executable, "-m", "uv", "--quiet", "pip", "install", "--python", sys.executable]
UV_LOCK = Path(__file__).with_name("requirements.txt")


def pip_settings():
    """Return the options that pip takes from its configuration files and the environment."""
    listed = subprocess.run([*PIP, "config", "list"], capture_output=True, text=True, check=True)
    settings = {}
    for section in ("global", "install", ":env:"):  # a later one overrides
        for line in listed.stdout.splitlines():
            name, _, value = line.partition("=")
            if name.startswith(f"{section}.") and ast.literal_eval(value):
                settings[name.removeprefix(f"{section}.")] = ast.literal_eval(value)
    return settings


def uv_environment(settings, environ):
    """Return the environment in which uv looks where pip would look.

    uv does not read pip's configuration. Variables that the user sets have priority.
    """
    several = {name: settings.get(name, "").split() for name in ("extra-index-url", "find-links")}
    found = {
        "UV_DEFAULT_INDEX": settings.get("index-url"),
        "UV_INDEX": " ".join(several["extra-index-url"]),
        "UV_INDEX_STRATEGY": "unsafe-best-match",  # pip's; the hashes make it safe
        "UV_FIND_LINKS": ",".join(several["find-links"]),
        "UV_INSECURE_HOST": settings.get("trusted-host"),
        "UV_HTTP_TIMEOUT": settings.get("timeout") or settings.get("default-timeout"),
        "UV_SYSTEM_CERTS": "true",
        "SSL_CERT_FILE": settings.get("cert")
        or environ.get("REQUESTS_CA_BUNDLE")
        or environ.get("CURL_CA_BUNDLE"),
        "SSL_CLIENT_CERT": settings.get("client-cert"),
        "ALL_PROXY": settings.get("proxy"),
    }
    return {name: value for name, value in found.items() if value} | dict(environ)


def install_with_uv(arguments):
    """Return whether uv could be fetched and installed what the arguments name."""
    try:
        if not importlib.util.find_spec("uv"):
            fetch = ["-qq", "install", "--require-hashes", "--requirement", str(UV_LOCK)]
            subprocess.run([*PIP, *fetch], check=True)
        settings = pip_settings()
        no_index = ["--no-index"] if settings.get("no-index") else []
        environment = uv_environment(settings, os.environ)
        subprocess.run([*UV, *no_index, *arguments], env=environment, check=True)
    except (OSError, subprocess.CalledProcessError, ValueError, SyntaxError):
        return False
    return True


def main(arguments):
    """Install the lock or the checkout that the arguments name; return the exit status."""
    if arguments[0] == "--editable":
        what = ["--no-deps", "--no-build-isolation", *arguments]
    else:
        what = ["--require-hashes", "--requirement", *arguments]
    print(f"Installing {'dem' if '--editable' in arguments else arguments[-1]}", flush=True)
    if install_with_uv(what):
        return 0
    print("Cannot use uv; pip installs the same versions, in a minute or two.", flush=True)
    return subprocess.run([*PIP, "-qq", "install", *what]).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
