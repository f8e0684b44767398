"""Shards of made-up boxes and gables, for the tests: the format of the README with truth by hand-written geometry."""

import json
from pathlib import Path

import numpy as np

from occupancy import safetensors
from occupancy.interface import EXTENT

RASTER = ("hit", "highest", "mean", "footprint_flag", "footprint_distance")
PLACE = ("x", "y", "z", "height", "ln_scale", "ln_radius", "footprint_flag", "footprint_coarse")
PATCH = ("offset_x", "offset_y", "offset_z", "distance", "plane_distance", "plane_upward", "on_plane")
SETUPS = ("full-view", "no-bottom", "airborne", "photographs", "real")


class Gable:
    """A gable along y (a box where eaves = ridge): |x| ≤ w, |y| ≤ l, 0 ≤ z ≤ roof(x); metres, ground at 0."""

    def __init__(self, random):
        self.w, self.l = random.uniform(2.0, 6.0), random.uniform(2.0, 8.0)
        self.eaves = random.uniform(2.5, 8.0)
        self.ridge = self.eaves + random.choice([0.0, random.uniform(0.5, 4.0)])
        self.scale = max(2 * self.w, 2 * self.l, self.ridge)

    def roof(self, x):
        """Height of the roof over x."""
        return self.ridge - (self.ridge - self.eaves) * np.abs(x) / self.w

    def inside(self, p):
        """Whether places [N, 3] lie inside."""
        return (np.abs(p[:, 0]) < self.w) & (np.abs(p[:, 1]) < self.l) & (p[:, 2] > 0) & (p[:, 2] < self.roof(p[:, 0]))

    def triangles(self):
        """The surface as triangles [F, 3, 3]."""

        def corners(y):
            return [
                (-self.w, y, 0),
                (self.w, y, 0),
                (self.w, y, self.eaves),
                (0, y, self.ridge),
                (-self.w, y, self.eaves),
            ]

        front, back = corners(-self.l), corners(self.l)
        faces = [front, back] + [[front[i], front[(i + 1) % 5], back[(i + 1) % 5], back[i]] for i in range(5)]
        return np.array([[face[0], face[i], face[i + 1]] for face in faces for i in range(1, len(face) - 1)], float)

    def distance(self, p):
        """Exact distance of places [N, 3] from the surface."""
        return np.min([triangle_distance(p, t) for t in self.triangles()], axis=0)

    def scan(self, count, random):
        """Points [count, 3] on the roof and some on the walls, with the normals' |z|."""
        triangles = self.triangles()
        normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        area = np.linalg.norm(normal, axis=1)
        upward = np.abs(normal[:, 2]) / area
        bottom = np.all(triangles[:, :, 2] == 0, axis=1)
        share = area * np.where(bottom, 0.0, np.where(upward < 0.1, 0.2, 1.0))
        which = random.choice(len(triangles), count, p=share / share.sum())
        u, v = random.random((2, count, 1))
        u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
        t = triangles[which]
        return (
            t[:, 0] + u * (t[:, 1] - t[:, 0]) + v * (t[:, 2] - t[:, 0]),
            upward[which],
            normal[which] / area[which, None],
        )


def triangle_distance(p, t):
    """Distance of places [N, 3] from a triangle [3, 3]."""
    found = np.full(len(p), np.inf)
    for i in range(3):
        a, edge = t[i], t[(i + 1) % 3] - t[i]
        s = np.clip((p - a) @ edge / (edge @ edge), 0, 1)
        found = np.minimum(found, np.linalg.norm(p - a - s[:, None] * edge, axis=1))
    normal = np.cross(t[1] - t[0], t[2] - t[0])
    sides = [np.cross(t[(i + 1) % 3] - t[i], p - t[i]) @ normal for i in range(3)]
    over = np.all(np.array(sides) >= 0, axis=0)
    return np.where(over, np.minimum(found, np.abs((p - t[0]) @ normal) / np.linalg.norm(normal)), found)


def cells(gable, count, samples, random):
    """Boxes as cells: samples [count · T, 3] (the centre first), true inside share and volume."""
    low = random.uniform([-1.3, -1.3, -0.1], [1.0, 1.0, 0.9], (count, 3)) * [gable.w, gable.l, gable.ridge]
    size = random.uniform(0.15, 0.6, (count, 3)) * [gable.w, gable.l, gable.ridge]
    places = low[:, None] + size[:, None] * random.random((count, samples, 3))
    places[:, 0] = low + size / 2
    dense = low[:, None] + size[:, None] * random.random((1, 200, 3))
    inside = gable.inside(dense.reshape(-1, 3)).reshape(count, 200).mean(axis=1)
    return places.reshape(-1, 3), inside, size.prod(axis=1)


def scan(layout, grid, neighbours, subsample, random, interface):
    """The tensors of one scan."""
    near, uniform, cell_count, samples = layout
    gable = Gable(random)
    points, upward, normals = gable.scan(random.integers(150, 400), random)
    scale = gable.scale
    places = [points[random.integers(len(points), size=near)] + random.normal(0, 0.04 * scale, (near, 3))]
    places.append(
        random.uniform(-0.6, 0.6, (uniform, 3)) * [2 * gable.w, 2 * gable.l, 0]
        + np.array([0, 0, 1.2 * gable.ridge]) * random.random((uniform, 3))
    )
    sampled, cell_inside, cell_volume = cells(gable, cell_count, samples, random)
    place = np.concatenate(places + [sampled])

    delta = points[None] - place[:, None]
    distance = np.linalg.norm(delta, axis=2)
    nearest = np.argsort(distance, axis=1)[:, np.arange(neighbours) % min(neighbours, len(points))]
    row = np.arange(len(place))[:, None]
    radius = distance[row, nearest].max(axis=1)
    offset = delta[row, nearest] / radius[:, None, None]
    plane = -(offset * normals[nearest]).sum(axis=2)
    patch = np.concatenate(
        [
            offset,
            np.linalg.norm(offset, axis=2)[..., None],
            np.abs(plane)[..., None],
            upward[nearest][..., None],
            np.ones_like(plane)[..., None],
        ],
        axis=2,
    )

    within = np.minimum(gable.w - np.abs(place[:, 0]), gable.l - np.abs(place[:, 1]))
    ones = np.ones(len(place))
    channels = [place / scale, place[:, 2] / 10, np.log(scale / 20) * ones, np.log(radius), ones, np.tanh(within / 2)]

    centre = -EXTENT + 2 * EXTENT * (np.arange(grid) + 0.5) / grid
    raster = np.zeros((len(RASTER), grid, grid), np.float32)
    column, line = (
        np.clip((points[:, i] / scale + EXTENT) / (2 * EXTENT) * grid, 0, grid - 1).astype(int) for i in (0, 1)
    )
    raster[0, line, column] = 1
    np.maximum.at(raster[1], (line, column), points[:, 2] / scale)
    count = np.zeros((grid, grid))
    np.add.at(count, (line, column), 1)
    np.add.at(raster[2], (line, column), points[:, 2] / scale)
    raster[2] /= np.maximum(count, 1)
    edge = np.minimum(gable.w / scale - np.abs(centre[None, :]), gable.l / scale - np.abs(centre[:, None]))
    raster[3], raster[4] = edge > 0, np.clip(4 * edge, -1, 1)

    inside = gable.inside(place)
    order = random.permutation(len(points))[np.arange(subsample) % len(points)]
    tensors = {
        "raster": raster.astype(np.float16),
        "subsample": (points[order] / scale).astype(np.float16),
        "place": np.concatenate([c.reshape(len(place), -1) for c in channels], axis=1).astype(np.float32),
        "patch": patch.astype(np.float16),
        "radius": radius.astype(np.float32),
        "inside": inside.astype(np.uint8),
        "known": np.ones(len(place), np.uint8),
        "distance": gable.distance(place).astype(np.float32),
        "cell_inside": cell_inside.astype(np.float32),
        "cell_known": np.ones(cell_count, np.float32),
        "cell_volume": cell_volume.astype(np.float32),
        "cell_vote": np.clip(cell_inside + random.normal(0, 0.3, cell_count), 0, 1).astype(np.float32),
        "scale": np.float32(scale),
        "exact": np.uint8(1),
        "setup": np.uint8(random.integers(3)),
        "noise": np.float32(random.uniform(0, 0.005)),
        "density": np.float32(len(points) / (4 * gable.w * gable.l)),
    }
    if interface == "points2surf":
        del tensors["raster"]
        tensors["place"], tensors["patch"] = tensors["place"][:, :3], tensors["patch"][..., :3]
    return tensors


def write(
    folder,
    *,
    scans=16,
    validation=8,
    shards=2,
    layout=(16, 12, 4, 8),
    grid=16,
    neighbours=8,
    subsample=200,
    seed=1,
    interface="field",
):
    """A folder of shards as `gable simulate` writes it."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(seed)
    field = interface == "field"
    for split, total in (("train", scans), ("validation", validation)):
        for index in range(shards):
            made = [scan(layout, grid, neighbours, subsample, random, interface) for _ in range(total // shards)]
            metadata = {
                "interface": interface,
                "version": "2",
                "split": split,
                "seed": seed,
                "setups": ",".join(SETUPS),
                "place_channels": ",".join(PLACE if field else PLACE[:3]),
                "patch_channels": ",".join(PATCH if field else PATCH[:3]),
                "near": layout[0],
                "uniform": layout[1],
                "cells": layout[2],
                "samples_per_cell": layout[3],
            }
            if field:
                metadata["raster_channels"] = ",".join(RASTER)
            tensors = {name: np.stack([one[name] for one in made]) for name in made[0]}
            safetensors.write(folder / f"{split}-{index:05}.safetensors", tensors, metadata)
    (folder / "manifest.json").write_text(json.dumps({"sources": [{"name": "boxes and gables", "scans": scans}]}))
