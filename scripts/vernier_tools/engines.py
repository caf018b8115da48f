"""Sets up a scene for either engine so that both solve the same problem in the same way.

Cycles' biases are switched off: clamping, the glossy filter, adaptive sampling, denoising, the
light threshold, few bounces. What remains is a path tracer with a light tree, as Vernier's is.
"""

from __future__ import annotations

import importlib

import bpy

from vernier_tools.errors import ToolError
from vernier_tools.jobs import Job

# Cycles' own upper limits: there Russian roulette has long ended the path.
CYCLES_MAX_BOUNCES = 1024
CYCLES_BOUNCES = (
    "max_bounces",
    "diffuse_bounces",
    "glossy_bounces",
    "transmission_bounces",
    "transparent_max_bounces",
)
CYCLES_MAX_SAMPLES = 2**24


def set_up(scene: bpy.types.Scene, job: Job, seed: int) -> None:
    """Makes `scene` ready for `bpy.ops.render.render()` as the job says. Raises ToolError."""
    render = scene.render
    if job.resolution != (0, 0):
        render.resolution_x, render.resolution_y = job.resolution
        render.resolution_percentage = 100
    if job.percentage:
        render.resolution_percentage = job.percentage
    render.threads_mode = "FIXED" if job.threads else "AUTO"
    if job.threads:
        render.threads = job.threads
    render.use_compositing = False
    render.use_sequencer = False
    render.dither_intensity = 0.0
    if job.engine.startswith("cycles"):
        set_up_cycles(scene, job, seed)
    else:
        set_up_vernier(scene, job, seed)


def set_up_cycles(scene: bpy.types.Scene, job: Job, seed: int) -> None:
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.seed = seed
    cycles.use_animated_seed = False
    cycles.samples = job.samples or CYCLES_MAX_SAMPLES
    cycles.time_limit = job.time
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = job.engine == "cycles-denoised"
    cycles.sample_clamp_direct = 0.0
    cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0
    cycles.light_sampling_threshold = 0.0
    cycles.use_light_tree = True
    cycles.use_guiding = False
    cycles.use_fast_gi = False
    cycles.caustics_reflective = True
    cycles.caustics_refractive = True
    for name in CYCLES_BOUNCES:
        setattr(cycles, name, CYCLES_MAX_BOUNCES)
    apply(cycles, job.settings, "Cycles")


def set_up_vernier(scene: bpy.types.Scene, job: Job, seed: int) -> None:
    register_vernier()
    scene.render.engine = "VERNIER"
    vernier = scene.vernier
    method = job.engine.partition("-")[2]
    vernier.integrator = "PATH" if method in ("", "denoised") else method.upper()
    if method == "denoised":
        importlib.import_module("addon.denoising").set_up(scene, scene.view_layers[0])
    vernier.seed = seed
    vernier.samples = job.samples or vernier.bl_rna.properties["samples"].hard_max
    vernier.time_limit = job.time
    # Cycles cannot do without a limit, so neither shall we here.
    vernier.max_bounces = CYCLES_MAX_BOUNCES
    vernier.transparent_bounces = CYCLES_MAX_BOUNCES
    cycles = getattr(scene, "cycles", None)
    if cycles is not None:
        kind = cycles.pixel_filter_type
        vernier.pixel_filter = kind
        # Cycles ignores the width that it shows for a box.
        vernier.filter_width = 1.0 if kind == "BOX" else cycles.filter_width
        vernier.film_exposure = cycles.film_exposure
    apply(vernier, job.settings, "Vernier")


def apply(settings: object, values: dict[str, object], engine: str) -> None:
    for name, value in values.items():
        if not hasattr(settings, name):
            raise ToolError(f"{engine} has no setting named {name}")
        setattr(settings, name, value)


def enable_cycles() -> None:
    """Makes Cycles available in a bare bpy."""
    bpy.ops.preferences.addon_enable(module="cycles")


def register_vernier() -> None:
    """Registers the project's add-on, once."""
    if not hasattr(bpy.types.Scene, "vernier"):
        importlib.import_module("addon").register()
        importlib.import_module("addon.record")
