"""The rooms of the package: which may import which."""

from importlinter.cli import EXIT_STATUS_SUCCESS, lint_imports


def test_a_room_imports_only_from_below(monkeypatch, request):
    """The contracts of pyproject.toml hold: layers without exception, no study imports another."""
    monkeypatch.chdir(request.config.rootpath)
    assert lint_imports(no_cache=True) == EXIT_STATUS_SUCCESS
