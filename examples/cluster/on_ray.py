"""All jobs of a plan on a Ray cluster, then the model of all.

python on_ray.py plan/ city.city.jsonl auto

Without an address the cluster is this machine. Run again, it does what is missing.
"""

import sys

import ray
from gable import distributed


def main(folder: str, model: str, address: str | None = None) -> None:
    ray.init(address=address)
    plan = distributed.Plan(folder)
    frame = distributed.run_on_ray(plan, progress=lambda _, done, total: print(f"{done} of {total} jobs"))
    print(frame[["footprints", "buildings_lod22", "wall_seconds", "peak_memory_bytes"]].describe())
    print(plan.merge(model, overwrite=True))


if __name__ == "__main__":
    main(*sys.argv[1:])
