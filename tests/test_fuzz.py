"""Bad input at random; `python tests/fuzz.py 10000` takes longer, and arrays too."""

import fuzz


def test_no_input_ends_in_a_traceback(monkeypatch):
    """Spoiled configurations, texts, command lines and files are taken or refused with a sentence."""
    monkeypatch.chdir(fuzz.ROOT)
    kinds = {kind: weight for kind, weight in fuzz.KINDS.items() if kind is not fuzz.an_array}
    assert fuzz.main(300, kinds=kinds) == 0
