"""What one engine is to render, what came out, and the process in which it happens.

Engines never share a process: neither their memory nor their libraries may touch the other's
measurement.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from vernier_tools.errors import ToolError

# What can be measured, and its name in tables. After "vernier-" comes an integrator.
ENGINES = {
    "vernier": "Vernier",
    "cycles": "Cycles",
    "vernier-bdpt": "Vernier BDPT",
    "vernier-light": "Vernier Light",
    "vernier-vcm": "Vernier VCM",
    "vernier-sppm": "Vernier SPPM",
    "vernier-photon": "Vernier Photon Mapping",
    "vernier-pssmlt": "Vernier PSSMLT",
    "vernier-mmlt": "Vernier MMLT",
    "vernier-mlt": "Vernier MLT",
    "vernier-auto": "Vernier Auto",
    "vernier-denoised": "Vernier, denoised",
    "cycles-denoised": "Cycles, denoised",
}
# What is measured where nothing else is asked for.
USUAL_ENGINES = ("vernier", "cycles")


@dataclass(frozen=True)
class GeneratedScene:
    """A measuring scene: `triangles` in one mesh, or as instances of a small one."""

    triangles: int
    instanced: bool


@dataclass(frozen=True)
class Job:
    """A render of `blend` (or of `generated`) by one engine, once for each seed.

    `samples` per pixel or `time` in seconds of sampling limits each render; the one not used is 0.
    `threads` 0 means all. `resolution` (0, 0) and `percentage` 0 keep the file's. `settings` are
    further properties of the engine's own settings. Pictures are `<output>-<seed>.exr`, linear, and
    with `view` also `.png`, as Blender shows them.
    """

    engine: str
    blend: str
    output: str
    seeds: tuple[int, ...] = (0,)
    samples: int = 0
    time: float = 0.0
    threads: int = 0
    resolution: tuple[int, int] = (0, 0)
    percentage: int = 0
    view: bool = False
    settings: dict[str, object] = field(default_factory=dict)
    generated: GeneratedScene | None = None
    photons: int = 0


@dataclass(frozen=True)
class Render:
    """One finished render. Times are seconds from the call; memory is in bytes.

    `first_sample` is when sampling began (export and building done), `first_tile` when the first
    pixels were there; `sampling` and `samples` say how long sampling lasted and what it achieved.
    `cpu` is the processor time of all threads, `sampling_cpu` that since sampling began. `memory`
    is by how much the process grew at its peak. `rays` is 0 where the engine does not count them,
    `error` infinite where it does not state one.
    """

    seed: int
    seconds: float
    cpu: float
    sampling_cpu: float
    first_sample: float
    first_tile: float
    sampling: float
    samples: float
    memory: int
    peak_memory: int
    rays: int
    error: float = math.inf

    def samples_per_cpu_second(self, pixels: int) -> float:
        """What else the machine does hardly touches it."""
        return self.samples * pixels / self.sampling_cpu


@dataclass(frozen=True)
class Outcome:
    """What a job's process did. `version` is Blender's; `warnings` are the engine's own."""

    engine: str
    version: str
    width: int
    height: int
    triangles: int
    renders: tuple[Render, ...]
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class RayRate:
    """Rays per second of processor time on one thread: of a render, and of Embree alone.

    Both cast the same `rays`, in the same order.
    """

    rays: int
    rendered: float
    bare: float


@dataclass(frozen=True)
class PhotonRate:
    """Processor seconds on one thread: of a million photons traced, stored and indexed, and of a
    million camera paths; of the 50 nearest photons of one point, and of SciPy's answer to the same.
    """

    photons: int
    paths: int
    bytes_of_photon: float
    map_seconds: float
    camera_seconds: float
    query_seconds: float
    scipy_seconds: float


def run(job: Job, timeout: float | None = None) -> Outcome:
    """Runs the job in a process of its own. Raises ToolError when it fails or takes too long."""
    return outcome_from_json(answer_of("worker", job, timeout))


def run_ray_rate(job: Job, timeout: float | None = None) -> RayRate:
    """Measures Vernier's rate of rays on the job's scene. Raises ToolError."""
    return RayRate(**answer_of("ray_rate", job, timeout))


def run_photon_rate(job: Job, timeout: float | None = None) -> PhotonRate:
    """Measures photons of the job's scene. Raises ToolError."""
    return PhotonRate(**answer_of("photon_rate", job, timeout))


def answer_of(module: str, job: Job, timeout: float | None) -> dict[str, Any]:
    """The JSON that the module writes of the job. Raises ToolError."""
    with tempfile.TemporaryDirectory() as folder:
        request, answer = Path(folder, "job.json"), Path(folder, "outcome.json")
        request.write_text(json.dumps(asdict(job)))
        command = [sys.executable, "-m", f"vernier_tools.{module}", str(request), str(answer)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
        except subprocess.TimeoutExpired as error:
            raise ToolError(f"{job.engine}: no end after {timeout:.0f} s") from error
        if done.returncode != 0 or not answer.exists():
            lines = [line for line in done.stderr.splitlines() if line.strip()]
            reason = lines[-1] if lines else f"the process ended with code {done.returncode}"
            raise ToolError(f"{ENGINES[job.engine]} on {job.blend or job.generated}: {reason}")
        result: dict[str, Any] = json.loads(answer.read_text())
        return result


def job_from_json(data: dict[str, Any]) -> Job:
    """The inverse of `json.dumps(asdict(job))`."""
    generated = data["generated"]
    return Job(
        **{
            **data,
            "seeds": tuple(data["seeds"]),
            "resolution": tuple(data["resolution"]),
            "generated": GeneratedScene(**generated) if generated else None,
        }
    )


def outcome_from_json(data: dict[str, Any]) -> Outcome:
    """The inverse of `json.dumps(asdict(outcome))`."""
    renders = tuple(Render(**render) for render in data["renders"])
    return Outcome(**{**data, "renders": renders, "warnings": tuple(data["warnings"])})
