"""A simulation goes on with the same bits, however it is cut, looked at, saved or interrupted."""

import copy
import io
import os
import pickle
import signal
import time
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest
from mechanics import assert_bits_are_the_same, assert_threads_change_no_bit, crowd, seen
from numpy.testing import assert_allclose
from project import posix, quick
from scenes import DAMPED, FREE, LEDGERS, SCENES, TO_AND_FRO, TURN, path, scene_of

import dem

LASTS = 2.0**-14  # s: about a hundred steps, at none of which it ends; its parts are exact numbers


def begun(make, share=0.25):
    """A simulation that has done a share of its time, which ends within a step."""
    run = make(dem.Simulation)
    run.advance(share * LASTS)
    return run


def finished(run):
    run.advance(LASTS - run.time)
    return run


def recorded(make):
    run = make(dem.Simulation)
    run.record(LASTS / 512, 512)  # shorter than a step
    return run


def framed(make):
    return make(dem.simulate, LASTS, frames=4).simulation


def continued(make):
    """A result can be continued as often as one likes."""
    first = make(dem.simulate, LASTS / 4)
    first.continuation(LASTS / 2)
    return first.continuation(3 * LASTS / 4, 3).simulation


def observed(make):
    run = make(dem.Simulation)
    for share in (0.1, 0.2, 0.25, 0.5):
        run.advance(share * LASTS - run.time)
        run.diagnose(), run.contacts(), run.stress(), run.collect_impulses()
    return finished(run)


def saved(make):
    """In a file, from which another one with other contacts goes on."""
    other, file = begun(make, 0.5), io.BytesIO()
    np.savez(file, **begun(make).checkpoint())
    file.seek(0)
    with np.load(file) as arrays:
        other.restore(arrays)
    return finished(other)


def copied(make, how):
    """What one does the other does not see."""
    run = begun(make)
    other = how(run)
    finished(run)
    return finished(other)


def forked(make):
    """In a child, to which no thread goes along."""
    run, (reads, writes) = begun(make), os.pipe()
    child = os.fork()
    if not child:
        with suppress(BaseException), os.fdopen(writes, "wb") as pipe:
            signal.alarm(60)
            pickle.dump(finished(run), pipe)
        os._exit(0)
    os.close(writes)
    with os.fdopen(reads, "rb") as pipe:
        other = pickle.load(pipe)
    assert os.waitpid(child, 0)[1] == 0
    return other


WAYS = {
    "recorded": recorded,
    "in frames": framed,
    "as a result that is continued": continued,
    "looked at": observed,
    "from a file": saved,
    "copied": partial(copied, how=copy.deepcopy),
    "pickled": partial(copied, how=lambda run: pickle.loads(pickle.dumps(run))),
    "forked": forked,
}
BEDS = *SCENES, "a crowd", "a crowd of two threads"


QUICK = "discs", "ellipses of local radius around solids", "a crowd of two threads"


def maker(bed):
    """Function that makes a simulation of the bed, or the result of one."""
    threads = {"threads": 2} if bed == "a crowd of two threads" else {}
    scene, state = crowd() if "crowd" in bed else scene_of(bed)
    usual = threads | {"ledger": bed in LEDGERS}
    return lambda make, *words, **options: make(scene, state, *words, **usual | options)


@cache
def undisturbed(bed):
    return seen(finished(maker(bed)(dem.Simulation)), LASTS / 8)


@pytest.mark.parametrize("bed", [pytest.param(bed, marks=[quick] * (bed in QUICK)) for bed in BEDS])
@pytest.mark.parametrize("way", WAYS)
def test_a_run_goes_on_with_the_same_bits(bed, way):
    """Motion, forces, contacts with their springs, boundaries and the choice of the time step."""
    way = WAYS[way]
    assert_bits_are_the_same(undisturbed(bed), seen(way(maker(bed)), LASTS / 8))


HELD = dem.Held(np.arange(0, 33**2, 3), FREE)
DENSE = crowd(lambda radius: dem.Disc(1.2 * radius), 33, walls=None, solids=None, held=[HELD])


@quick
@pytest.mark.parametrize("bed", [crowd(), crowd(side=33), DENSE], ids=["many", "few", "dense"])
def test_the_number_of_threads_changes_no_bit(bed):
    """Also where one thread has hardly anything to do, and no boundary near; and where many granules of a group feel
    those of the other thread. Other granules are asked at night."""
    assert_threads_change_no_bit(*bed)


CHANGES = {
    "a velocity": lambda run: run.set_motion(0, (1.0, -2.0), spin=30.0),
    "a path": lambda run: run.set_motion(0, path(*TO_AND_FRO)),
    "a force and a torque": lambda run: run.set_motion(0, DAMPED, TURN),
    "removed": lambda run: run.remove(0),
}


def moved(run):
    """The smallest granule is put where the largest was, which is gone."""
    sizes, place = run.scene.shape.bounding_radius, run.state.position
    run.remove_granules([sizes.argmin(), sizes.argmax()])
    run.insert_granules([sizes.argmin()], place[[sizes.argmax()]], angular_velocity=[500.0])


OTHERS = {"granules that go": lambda run: run.remove_granules([0, 12]), "one that is moved": moved}


@pytest.mark.parametrize("change", CHANGES | OTHERS)
def test_a_run_goes_on_with_another_motion_of_a_solid_or_with_other_granules(change):
    """A checkpoint keeps it for another simulation of the scene; one from before undoes it."""
    make = partial(maker("box of discs"), ledger=True)  # as others are where a solid is driven
    run, other = begun(make), begun(make, 0.5)
    before = run.checkpoint()
    (CHANGES | OTHERS)[change](run)
    other.restore(run.checkpoint())
    assert_bits_are_the_same(*(seen(simulation, LASTS / 8) for simulation in (run, other)))
    run.restore(before)
    ends = (seen(finished(simulation), LASTS / 8) for simulation in (begun(make), run))
    assert_bits_are_the_same(*ends)


@pytest.mark.parametrize("change", CHANGES)
def test_other_contacts_keep_their_springs_where_a_solid_moves_otherwise(change):
    run = dem.Simulation(*scene_of("box of discs"), time_step=1e-7, ledger=True)
    run.advance(2e-5)
    before = run.contacts()
    CHANGES[change](run)
    after = run.contacts()
    springs = [c.tangential_force[c.partner != -1] for c in (before, after)]
    assert np.abs(springs[0]).max() > 0.0
    assert_allclose(*springs, rtol=1e-5)  # those that slide change with the step


def test_a_checkpoint_of_another_scene_is_refused():
    scene, state = scene_of("box of discs")
    run = dem.Simulation(scene, state)
    with pytest.raises(dem.InputError, match="of another scene"):
        dem.Simulation(replace(scene, gravity=(0.0, -1.0)), state).restore(run.checkpoint())


ENDLESS = {
    "advance": lambda run: run.advance(10.0),
    "record": lambda run: run.record(1e-9, 10_000_000),
    "one interval": lambda run: run.record(10.0, 1),
}


@posix
@pytest.mark.parametrize("call", ENDLESS)
@pytest.mark.parametrize("threads", [1, 2])
def test_an_interrupt_is_answered_and_loses_nothing(call, threads):
    """What was simulated until then is what a run of that time has, and goes on like it."""
    scene, state = crowd()
    run, calm = (dem.Simulation(scene, state, 1e-8, threads=threads) for _ in range(2))
    signal.signal(signal.SIGALRM, signal.default_int_handler)  # as a Ctrl-C
    for moment in (0.3, 0.02, 0.1):
        began, before = time.monotonic(), run.steps
        signal.setitimer(signal.ITIMER_REAL, moment)
        with pytest.raises(KeyboardInterrupt):
            ENDLESS[call](run)
        assert time.monotonic() - began < 60.0  # s, on a busy computer; the run takes hours
        at, steps = run.time, run.steps
        time.sleep(0.1)
        assert (run.time, run.steps) == (at, steps) and steps > before
        assert at == pytest.approx(1e-8 * steps, abs=1e-8)
    calm.advance(run.time)
    assert_bits_are_the_same(seen(calm, 1e-7), seen(run, 1e-7))
