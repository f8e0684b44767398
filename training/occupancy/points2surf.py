"""Points2Surf ("vanilla", Erler et al. 2020) as the Points2Poly paper uses it, section 3.3: two PointNets per query.

Both sets are translated so that the query is the origin; one quaternion network (QSTN) turns both. Everything runs once
per query, which is why the field network exists. Point features are rows of one matrix ([B·P, C]), so that a 1×1
convolution is a matrix product and BatchNorm folds into it at export.
"""

import torch
from torch import nn


class Points2Surf(nn.Module):
    """Interface "points2surf": patch [B, 300, 3] and subsample [B, 1000, 3] to [B, 2].

    `width` is the number of features under the maximum: 1024 in the paper. The other layers shrink in proportion,
    but not below the sizes that keep the feature transformation meaningful.
    """

    def __init__(self, interface, width=1024):
        super().__init__()
        self.interface = interface
        narrow, middle = max(width // 16, 16), max(width // 8, 32)
        sizes = (narrow, middle, width)
        self.turn = QuaternionNet(sizes)
        self.near = PointNet(sizes)
        self.far = PointNet(sizes)
        self.near_code = Layer(width, width // 2)
        self.far_code = Layer(width, width // 2)
        self.head = nn.Sequential(Layer(width, width // 4), Layer(width // 4, width // 8))
        self.sign = nn.Linear(width // 8, 1)
        self.distance = nn.Linear(width // 8, 1)

    def forward(self, batch):
        """Answers [n·Q, 2] (sign logit, raw p with |d| = r·|p|) of a batch: subsample [n, 1000, 3], place, patch."""
        place, patch = batch["place"][..., :3], batch["patch"].flatten(0, 1)
        queries = place.shape[1]
        owner = torch.arange(place.shape[0], device=place.device).repeat_interleave(queries)
        place = place.flatten(0, 1)
        # BatchNorm needs the whole batch in training; evaluation goes in pieces that fit into memory.
        piece = len(place) if self.training else 128
        answers = []
        for start in range(0, len(place), piece):
            part = slice(start, start + piece)
            around = batch["subsample"][owner[part]] - place[part].unsqueeze(1)
            answers.append(self.decode(patch[part], around))
        return torch.cat(answers)

    def hidden(self, patch, subsample):
        """The features [B, H] that both answers are read from."""
        turn = self.turn(torch.cat([patch, subsample], dim=1))
        near = self.near_code(self.near(torch.bmm(patch, turn)))
        far = self.far_code(self.far(torch.bmm(subsample, turn)))
        return self.head(torch.cat([near, far], dim=1))

    def decode(self, patch, subsample):
        """patch [B, K, 3] (Δ / r) and subsample [B, M, 3] (the query is the origin) to [B, 2]."""
        hidden = self.hidden(patch, subsample)
        return torch.cat([self.sign(hidden), self.distance(hidden)], dim=1)

    def standardise(self, batch):
        """Nothing to fix: both sets come in their own fixed scale."""


class Layer(nn.Module):
    """Linear, BatchNorm and, unless told otherwise, ReLU on rows [N, C]."""

    def __init__(self, inputs, outputs, activation=True):
        super().__init__()
        self.linear = nn.Linear(inputs, outputs)
        self.norm = nn.BatchNorm1d(outputs)
        self.activation = nn.ReLU() if activation else nn.Identity()

    def forward(self, rows):
        return self.activation(self.norm(self.linear(rows)))

    @torch.no_grad()
    def fold(self):
        """Write the normalisation of evaluation into the linear layer."""
        factor = self.norm.weight / (self.norm.running_var + self.norm.eps).sqrt()
        self.linear.bias.copy_((self.linear.bias - self.norm.running_mean) * factor + self.norm.bias)
        self.linear.weight.mul_(factor.unsqueeze(1))
        self.norm = nn.Identity()


class Pooled(nn.Module):
    """Layers on every point of [B, P, C], then the maximum over the points: [B, W]."""

    def __init__(self, inputs, sizes, last_activation=True):
        super().__init__()
        layers = []
        for i, size in enumerate(sizes):
            layers.append(Layer(inputs, size, activation=last_activation or i + 1 < len(sizes)))
            inputs = size
        self.layers = nn.Sequential(*layers)

    def forward(self, points):
        count, each, channels = points.shape
        return self.layers(points.reshape(count * each, channels)).reshape(count, each, -1).amax(dim=1)


class QuaternionNet(nn.Module):
    """The rotation [B, 3, 3] that a set of points is turned by; the identity when untrained."""

    def __init__(self, sizes):
        super().__init__()
        width = sizes[-1]
        self.pooled = Pooled(3, sizes)
        self.layers = nn.Sequential(Layer(width, width // 2), Layer(width // 2, width // 4))
        self.quaternion = nn.Linear(width // 4, 4)
        nn.init.zeros_(self.quaternion.weight)
        with torch.no_grad():
            self.quaternion.bias.copy_(torch.tensor([1.0, 0.0, 0.0, 0.0]))
        # Products q_i·q_j picked by constant matrices: an export without Gather or Slice.
        left, right, terms = quaternion_terms()
        for name, matrix in (
            ("left", left),
            ("right", right),
            ("terms", terms),
            ("ones", torch.ones(4, 1)),
            ("identity", torch.eye(3).reshape(1, 9)),
        ):
            self.register_buffer(name, matrix)

    def forward(self, points):
        q = self.quaternion(self.layers(self.pooled(points)))
        products = (q @ self.left) * (q @ self.right)
        return (products @ self.terms / ((q * q) @ self.ones) + self.identity).reshape(-1, 3, 3)


def quaternion_terms():
    """Matrices A, B [4, 9] and C [9, 9] with R − I = ((qA)·(qB)) C / |q|² for the quaternion q = (w, x, y, z)."""
    w, x, y, z = range(4)
    pairs = [(x, x), (y, y), (z, z), (x, y), (x, z), (y, z), (w, x), (w, y), (w, z)]
    # Rows of R − I, times |q|²: each entry is 2 × (sign × product) summed over the listed pairs.
    entries = [
        [(-1, y, y), (-1, z, z)],
        [(1, x, y), (-1, w, z)],
        [(1, x, z), (1, w, y)],
        [(1, x, y), (1, w, z)],
        [(-1, x, x), (-1, z, z)],
        [(1, y, z), (-1, w, x)],
        [(1, x, z), (-1, w, y)],
        [(1, y, z), (1, w, x)],
        [(-1, x, x), (-1, y, y)],
    ]
    left, right, terms = torch.zeros(4, 9), torch.zeros(4, 9), torch.zeros(9, 9)
    for i, (a, b) in enumerate(pairs):
        left[a, i] = 1.0
        right[b, i] = 1.0
    for j, entry in enumerate(entries):
        for sign, a, b in entry:
            terms[pairs.index((a, b)), j] = 2.0 * sign
    return left, right, terms


class PointNet(nn.Module):
    """Points [B, P, 3] to a code [B, W], with a learned transformation of the features in between."""

    def __init__(self, sizes):
        super().__init__()
        narrow, _, width = sizes
        self.narrow = narrow
        self.first = nn.Sequential(Layer(3, narrow), Layer(narrow, narrow))
        self.stn = Pooled(narrow, sizes)
        self.stn_layers = nn.Sequential(Layer(width, width // 2), Layer(width // 2, width // 4))
        self.transformation = nn.Linear(width // 4, narrow * narrow)
        nn.init.zeros_(self.transformation.weight)
        nn.init.zeros_(self.transformation.bias)
        self.register_buffer("identity", torch.eye(narrow).reshape(1, narrow * narrow))
        self.last = Pooled(narrow, sizes, last_activation=False)

    def forward(self, points):
        count, each, _ = points.shape
        features = self.first(points.reshape(count * each, 3)).reshape(count, each, self.narrow)
        matrix = self.transformation(self.stn_layers(self.stn(features))) + self.identity
        return self.last(torch.bmm(features, matrix.reshape(-1, self.narrow, self.narrow)))
