"""All jobs of a plan on a Dask cluster, then the model of all.

python on_dask.py plan/ city.city.jsonl tcp://head:8786

Without an address the cluster is this machine. Run again, it does what is missing.
"""

import sys

from dask.distributed import Client
from gable import distributed


def main(folder: str, model: str, address: str | None = None) -> None:
    plan = distributed.Plan(folder)
    with Client(address) if address else Client(threads_per_worker=1) as client:
        frame = distributed.run_on_dask(plan, client, progress=lambda _, done, total: print(f"{done} of {total} jobs"))
    print(frame[["footprints", "buildings_lod22", "wall_seconds", "peak_memory_bytes"]].describe())
    print(plan.merge(model, overwrite=True))


if __name__ == "__main__":
    main(*sys.argv[1:])
