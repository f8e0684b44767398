"""The alternatives to the raster as the global branch: one code, or tokens. Ablations only: neither is exported."""

import torch
from torch import nn


class PointCode(nn.Module):
    """One code for the whole building: a PointNet with a maximum over the sub-sample, as in DeepSDF."""

    def __init__(self, code, widths=(32, 64, 128)):
        super().__init__()
        layers, inputs = [], 3
        for width in widths:
            layers += [nn.Linear(inputs, width), nn.ReLU()]
            inputs = width
        self.points = nn.Sequential(*layers)
        self.code = nn.Linear(inputs, code)

    def forward(self, subsample, place):
        """subsample [n, 1000, 3] and places [n, Q, 3] to one code per query [n·Q, D], equal within a building."""
        n, count, _ = subsample.shape
        code = self.code(self.points(subsample.reshape(n * count, 3)).reshape(n, count, -1).amax(dim=1))
        return code.repeat_interleave(place.shape[1], dim=0)


class TokenCode(nn.Module):
    """Tokens at anchors of the sub-sample, pooled by attention over those nearest to the query.

    This is the paper's query-centred global set with the per-point part computed once per building.
    """

    def __init__(self, code, anchors=128, neighbours=16, nearest=16, width=48):
        super().__init__()
        self.anchors, self.neighbours, self.nearest = anchors, neighbours, nearest
        self.local = nn.Sequential(nn.Linear(5, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU())
        self.whole = nn.Sequential(nn.Linear(width + 3, width), nn.ReLU())
        self.token = nn.Linear(2 * width + 3, width)
        self.relative = nn.Linear(5, width)
        self.value = nn.Sequential(nn.Linear(width, width), nn.ReLU())
        self.weight = nn.Linear(width, 1)
        self.code = nn.Linear(width, code)

    def forward(self, subsample, place):
        """subsample [n, 1000, 3] in random order and places [n, Q, 3] to [n·Q, D]."""
        n, queries = place.shape[:2]
        # The order is random, so the first points are a uniform sample themselves.
        anchors = subsample[:, : self.anchors]
        near = torch.cdist(anchors, subsample).topk(self.neighbours, largest=False).indices
        local = self.local(offsets(gather(subsample, near) - anchors.unsqueeze(2))).amax(dim=2)
        whole = self.whole(torch.cat([local, anchors], dim=2)).amax(dim=1, keepdim=True).expand_as(local)
        tokens = self.token(torch.cat([local, whole, anchors], dim=2))
        near = torch.cdist(place, anchors).topk(self.nearest, largest=False).indices
        relative = self.relative(offsets(gather(anchors, near) - place.unsqueeze(2)))
        values = self.value(torch.relu(gather(tokens, near) + relative))
        weights = self.weight(values).softmax(dim=2)
        return self.code((values * weights).sum(dim=2)).reshape(n * queries, -1)


def gather(rows, indices):
    """The rows [n, R, W] at indices [n, A, K]: [n, A, K, W]."""
    n, a, k = indices.shape
    flat = indices.reshape(n, a * k, 1).expand(-1, -1, rows.shape[2])
    return rows.gather(1, flat).reshape(n, a, k, rows.shape[2])


def offsets(delta):
    """An offset [..., 3] with its length and its horizontal length: [..., 5]."""
    horizontal = delta[..., :2].square().sum(dim=-1, keepdim=True)
    # The small number keeps the slope of the root finite at the anchor itself.
    length = horizontal + delta[..., 2:].square()
    return torch.cat([delta, (length + 1e-12).sqrt(), (horizontal + 1e-12).sqrt()], dim=-1)
