"""Long renders to measure others against, kept on disk between runs of the benchmark."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from vernier_tools import environment, images, jobs, metrics
from vernier_tools.images import FloatImage

# Far from the seeds that are measured: a reference must be independent of these.
SEEDS = (1_000_001, 1_000_002)


@dataclass(frozen=True)
class Reference:
    """The mean of one long render by each engine: each is two independent halves.

    `noise` is the reference's own expected relative squared error, which every picture measured
    against it shows on top of its own.
    """

    image: FloatImage
    noise: float
    halves: dict[str, tuple[FloatImage, FloatImage]]

    def error_of(self, image: FloatImage) -> float:
        """Relative squared error without the reference's share (so about the true error)."""
        return metrics.relative_squared_error(image, self.image) - self.noise


def make(job: jobs.Job, engines: Sequence[str], seconds: float, cache: Path) -> Reference:
    """The reference for the job's scene and size, `seconds` by each engine. Raises ToolError."""
    halves = {engine: long_render(job, engine, seconds, cache) for engine in engines}
    image = np.asarray(sum(a + b for a, b in halves.values()) / (2 * len(halves)), np.float32)
    # The variance of a mean of n independent pictures: the mean of their variances over n.
    noises = [metrics.relative_noise(pair, image) for pair in halves.values()]
    return Reference(image, sum(noises) / len(noises) ** 2, halves)


def long_render(
    job: jobs.Job, engine: str, seconds: float, cache: Path
) -> tuple[FloatImage, FloatImage]:
    """Two halves of half the time each, from the cache when they are there."""
    job = replace(job, engine=engine, output="", seeds=SEEDS, time=seconds / 2, samples=0)
    key = hashlib.sha256(json.dumps(asdict(replace(job, blend=""))).encode())
    key.update(Path(job.blend).read_bytes())
    if not engine.startswith("cycles"):
        key.update(environment.source_hash(Path(__file__).parents[2]).encode())
    stem = cache / f"{Path(job.blend).stem}-{engine}-{key.hexdigest()[:16]}"
    paths = [stem.with_name(f"{stem.name}-{seed}.exr") for seed in SEEDS]
    if not all(path.exists() for path in paths):
        cache.mkdir(parents=True, exist_ok=True)
        jobs.run(replace(job, output=str(stem)))
    return images.read_combined(paths[0]), images.read_combined(paths[1])
