"""Questions that a class answers, such as a shape or a law of contacts, with plain functions.

A question is a function whose first argument is a NamedTuple. The class of that selects the answer:
at each call in Python, and once for a kernel (dem.jit.kernel), where nothing is left of the choice.
"""

import functools

from dem.base.errors import InputError


def question(stub):
    """Decorator: a function whose body is the default answer; a class must answer a stub that
    raises NotImplementedError."""
    answers = {}

    @functools.wraps(stub)
    def asked(first, *rest):
        return answers.get(type(first), stub)(first, *rest)

    asked.answers = answers
    asked.has_default = "NotImplementedError" not in stub.__code__.co_names
    return asked


def register(cls, *functions, questions, members, usual, **renamed):
    """Make a class known to the kernels: each function answers the question of its name, or of the
    keyword that it is given for.

    members: attributes that the class must have; usual: a class whose members are the defaults.
    Raises InputError for an unknown question, an unanswered one without a default, or a missing
    member.
    """
    functions = {function.__name__: function for function in functions} | renamed
    known = {question.__name__: question for question in questions}
    needed = {name for name, asked in known.items() if not asked.has_default}
    if not needed <= functions.keys() <= known.keys():
        raise InputError(
            f"{cls.__name__} answers {', '.join(functions)}; it must answer the questions "
            f"{', '.join(sorted(needed))} of the kernels, and may answer "
            f"{', '.join(sorted(known.keys() - needed))}."
        )
    for name in dir(usual):
        if not hasattr(cls, name):
            setattr(cls, name, getattr(usual, name))
    for name in members:
        if not hasattr(cls, name):
            raise InputError(
                f"{cls.__name__} has no {name}; see {usual.__module__}.{usual.__name__}."
            )
    for name, asked in known.items():
        asked.answers[cls] = functions.get(name, asked.__wrapped__)
