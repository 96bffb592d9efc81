"""Questions of the kernels that a class answers, such as a shape or a law of contacts.

A question is a function whose first argument is a NamedTuple. The class of that selects the answer: at
compile time in kernels, where nothing is left of the choice, and at each call in Python.
"""

import functools

from numba.extending import overload, register_jitable

from dem.base.errors import InputError
from dem.jit.compilation import INLINED, remember


def question(stub):
    """Decorator: a function whose body is that of a class that answers nothing else; a stub that
    raises NotImplementedError must be answered."""
    answers = {}
    default = "NotImplementedError" not in stub.__code__.co_names

    @functools.wraps(stub)
    def asked(first, *rest):
        return answers.get(type(first), stub)(first, *rest)

    def choose(first, *rest):
        return answers.get(getattr(first, "instance_class", None), stub if default else None)

    overload(asked, strict=False, jit_options=INLINED)(choose)
    asked.answers, asked.has_default = answers, default
    return asked


def register(cls, *functions, questions, members, usual, **renamed):
    """Make a class known to the kernels: each function answers the question of its name, or of the
    keyword that it is given for.

    members: what Python asks of the class, beside what the class `usual` has, whose members it gets
    where it has none. Raises InputError for an unknown question, an unanswered one without a
    default, a missing member, or a class with the name of another one.
    """
    if any(other is not cls and other.__name__ == cls.__name__ for other in questions[0].answers):
        raise InputError(
            f"{cls.__name__} is the name of a class that the kernels know already, and Numba tells "
            "classes apart by their names; choose another name, or start Python, or the workers, "
            "again."
        )
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
    for name, function in functions.items():
        known[name].answers[cls] = register_jitable(**INLINED)(function)  # one may call another
    remember(cls)
