"""Small and large beds: the time of one step of one granule, on one thread and on several."""

import time
from dataclasses import replace

import numpy as np

from dem.dynamics.simulation import STEP_FRACTION, Simulation
from dem.material import Friction, Material
from dem.packing.random import Bed, pack
from dem.scene import Scene, State
from dem.shapes.disc import Disc
from dem.solids import box
from dem.sweep.config import Sweep
from studies.common.peers import lammps
from studies.common.peers.program import absent

TILES = (1, 4, 16, 50)  # along each side of a bed: of 400 granules, to a million
RANKED = 102_400  # discs of the bed that LAMMPS runs too
STEPS = 100  # of each run, all from the same start: fewer than a list holds
SPEED = 0.5  # m/s, of the granules at the start, a quarter of the cylinder's
SEED = 1


def large_scene(sweep: Sweep, side: int):
    """Scene and State of side x side mirrored tiles of the sweep's discs, all granules in motion.

    Frictional, damped, in a box without a cylinder.
    """
    label = next(label for label, shape in sweep.shapes.items() if shape.kind == "disc")
    replicate = sweep.replicate(label, sweep.density_of(label), SEED)
    sizes, room = replicate.diameters, sweep.cylinder.diameter**2 * np.pi / 4.0 / sweep.box_width
    height = replicate.bed_description.height(sizes) - room
    bed = pack(Disc.of_size(sizes), sweep.box_width, height, None, SEED)
    state = tiled(bed, side)
    shape = Disc.of_size(np.tile(sizes, side**2))
    material = Material(**sweep.material.model_dump(exclude={"thickness"}))
    walls = box(side * bed.width, side * bed.height)
    scene = Scene(shape, material, Friction(), walls, thickness=replicate.shape.diameter)
    random = np.random.default_rng(SEED)
    return scene, replace(state, velocity=SPEED * random.normal(size=state.position.shape))


def tiled(bed: Bed, side: int) -> State:
    """State of side x side mirrored copies of a bed of discs without a cylinder.

    A disc on a rigid wall feels the same force from its own mirror image: the pair overlaps twice
    as far, with half the effective modulus and half the effective radius. So the copies are at rest
    too.
    """
    tile = np.stack(np.divmod(np.arange(side**2), side), axis=-1)[:, None]
    size = [bed.width, bed.height]
    place = bed.position / size
    place = tile + np.where(tile % 2, 1.0 - place, place)
    return State((place * size).reshape(-1, 2))


def bytes_a_granule(world) -> float:
    """Memory (bytes) of all arrays of the kernels, neighbour lists included, over the granules."""
    arrays, left = {}, [world]
    while left:
        for item in left.pop():
            if isinstance(item, np.ndarray):
                arrays[item.__array_interface__["data"][0]] = item.nbytes
            elif isinstance(item, tuple):
                left.append(item)
    return sum(arrays.values()) / len(world.bodies)


def compare_sizes(sweep: Sweep, turns: int, threads=(1, 2), tiles=TILES) -> dict:
    """Variables: seconds per granule and step by size and threads, of LAMMPS on as many ranks, and
    memory per granule."""
    ranked = not (lammps.available() or absent(lammps.MPIEXEC))
    beds = [large_scene(sweep, side) for side in tiles]
    times, ranks = np.full((2, len(beds), len(threads), turns), np.nan)
    memory = np.empty(len(beds))
    for turn in range(-1, turns):  # the first compiles and does not count
        for place, (scene, state) in enumerate(beds):
            runs = max(1, 50_000 // scene.granules)
            for column, number in enumerate(threads):
                spent = 0.0
                for _ in range(runs):
                    run = Simulation(scene, state, threads=number)
                    step = STEP_FRACTION * run.diagnose().critical_time_step
                    started = time.perf_counter()
                    run.advance(STEPS * step)
                    spent += (time.perf_counter() - started) / run.steps
                memory[place] = bytes_a_granule(run.world)
                if turn >= 0:
                    times[place, column, turn] = spent / runs / scene.granules
                if turn >= 0 and ranked and scene.granules == RANKED:
                    (leg,) = lammps.run(scene, state, step, (STEPS,), ranks=number)
                    ranks[place, column, turn] = leg.time / STEPS / RANKED
    return {
        "size": np.array([scene.granules for scene, _ in beds]),
        "threads": np.array(threads),
        "size_step_time": times,
        "ranks_step_time": ranks,
        "size_memory": memory,
    }
