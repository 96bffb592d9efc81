"""The threads that take steps and survey a bed together."""

from concurrent.futures import ThreadPoolExecutor

from dem.dynamics.diagnostics import Diagnostics, begin_survey, deeper, end_survey, survey_pairs
from dem.dynamics.integration import advance
from dem.dynamics.synchronise import make_threads, portion
from dem.jit.lanes import make_lanes


class Threads:
    """A number of threads, each with its own place and scratch lanes."""

    def __init__(self, threads: int):
        self._places = make_threads(threads)
        self._lanes = [make_lanes() for _ in range(threads)]
        self._pool = ThreadPoolExecutor(threads)

    def advance(self, world, dt, steps, rebuild_at):
        """As dem.dynamics.integration.advance, with the same result for any number of threads."""
        runs = [
            self._pool.submit(advance, world._replace(lanes=lanes), dt, steps, rebuild_at, thread)
            for thread, lanes in zip(self._places, self._lanes, strict=True)
        ]
        results = [run.result() for run in runs]
        return results[0]

    def diagnose(self, world, table) -> Diagnostics:
        """As dem.dynamics.diagnostics.diagnose, with the same result for any number of threads.

        Held granules share the row of their group, so that one thread surveys all.
        """
        granules = len(world.bodies)
        shares = [portion(place, granules) for place in self._places]
        shares = shares if world.held is None else [(0, granules)]
        begun = begin_survey(world, table, len(shares))
        bounds, spare = begun[2], len(begun[2].rows) - len(shares)
        surveys = [
            self._pool.submit(survey_pairs, world, table, bounds, *share, spare + k)
            for k, share in enumerate(shares)
        ]
        found = [survey.result() for survey in surveys]
        worst = 0.0, 0
        for _, (overlap, constituent) in found:
            worst = deeper(worst, overlap, constituent, 1.0)
        return end_survey(world, table, begun, (sum(touching for touching, _ in found), worst))
