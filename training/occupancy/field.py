"""The field network: one code of the building, looked up at the query, and a local branch on its nearest points.

The building is encoded once; a query then costs about 31 000 multiplications. The decoder looks the code up at the
query, adds the query's place and the pooled features of its nearest points, and answers with sign and distance.
"""

import torch
from torch import nn
from torch.nn import functional

from .codes import PointCode, TokenCode
from .interface import EXTENT


class FieldNetwork(nn.Module):
    """Encoder (per building) and decoder (per query) of the interface "field".

    `branch` chooses the global branch: "raster" (the shipped one: a U-Net over the raster, looked up bilinearly),
    "tokens" (anchors of the sub-sample, attended to by the query), "code" (one PointNet vector), or "none".
    `local` switches the branch on the nearest points.
    """

    def __init__(
        self,
        interface,
        branch="raster",
        widths=(16, 32, 48, 64),
        code=24,
        local=True,
        patch=(32, 32),
        head=(64, 64),
        anchors=128,
    ):
        super().__init__()
        self.interface, self.branch, self.local = interface, branch, local
        if branch == "raster":
            self.encoder = RasterCode(len(interface.raster_channels), widths, code)
        elif branch == "tokens":
            self.encoder = TokenCode(code, anchors)
        elif branch == "code":
            self.encoder = PointCode(code)
        elif branch == "none":
            self.encoder, code = None, 0
        else:
            raise ValueError(f'branch "{branch}" is unknown; it is "raster", "tokens", "code" or "none"')
        self.decoder = Decoder(code, len(interface.place_channels), len(interface.patch_channels), local, patch, head)

    def forward(self, batch):
        """Answers [n·Q, 2] (sign logit, distance logit) of a batch: dictionary of raster, subsample, place, patch."""
        place = batch["place"]
        if self.branch == "raster":
            code = look_up(self.encoder(batch["raster"]), place[..., :2])
        elif self.branch == "none":
            code = place.new_zeros(place.shape[0] * place.shape[1], 0)
        else:
            code = self.encoder(batch["subsample"], place[..., :3])
        return self.decoder(code, place.flatten(0, 1), batch["patch"].flatten(0, 1))

    @torch.no_grad()
    def standardise(self, batch):
        """Fix the scaling of the inputs from one large batch of training data."""
        if self.branch == "raster":
            self.encoder.standardise(batch["raster"])
        self.decoder.standardise(batch["place"].flatten(0, 1))


def look_up(codes, xy):
    """Bilinear look-up of `codes` [n, D, G, G] at `xy` [n, Q, 2] of the frame: [n·Q, D]."""
    found = functional.grid_sample(
        codes, (xy / EXTENT).unsqueeze(1), mode="bilinear", padding_mode="border", align_corners=False
    )
    return found.squeeze(2).transpose(1, 2).flatten(0, 1)


class RasterCode(nn.Module):
    """A small U-Net: raster [n, C, G, G] to code [n, D, G, G]; G is divisible by 2^(levels − 1)."""

    def __init__(self, channels, widths, code):
        super().__init__()
        self.register_buffer("factor", torch.ones(1, channels, 1, 1))
        self.stem = convolution(channels, widths[0])
        self.down = nn.ModuleList()
        for i in range(1, len(widths)):
            self.down.append(
                nn.Sequential(convolution(widths[i - 1], widths[i], stride=2), convolution(widths[i], widths[i]))
            )
        self.narrow, self.up = nn.ModuleList(), nn.ModuleList()
        for i in reversed(range(1, len(widths))):
            # Narrowing before the enlargement does the same work on a quarter of the pixels.
            self.narrow.append(convolution(widths[i], widths[i - 1], size=1))
            last = i == 1
            self.up.append(convolution(2 * widths[i - 1], code if last else widths[i - 1], activation=not last))

    def forward(self, raster):
        return self.codes(raster * self.factor)

    def codes(self, raster):
        """The code of a raster that is scaled already."""
        level = self.stem(raster)
        levels = [level]
        for down in self.down:
            level = down(level)
            levels.append(level)
        levels.pop()
        for narrow, up in zip(self.narrow, self.up):
            larger = functional.interpolate(narrow(level), scale_factor=2.0, mode="nearest")
            level = up(torch.cat([larger, levels.pop()], dim=1))
        return level

    def standardise(self, raster):
        """Scale each channel to a root mean square of 1. No shift: empty pixels and the padding stay 0."""
        size = raster.square().mean(dim=(0, 2, 3), keepdim=True).sqrt()
        self.factor.copy_(torch.where(size > 1e-6, 1.0 / size.clamp(min=0.05), torch.ones_like(size)))


def convolution(inputs, outputs, stride=1, size=3, activation=True):
    """Convolution that keeps the size (divided by the stride), and a ReLU."""
    layer = nn.Conv2d(inputs, outputs, size, stride=stride, padding=size // 2)
    return nn.Sequential(layer, nn.ReLU()) if activation else layer


class Decoder(nn.Module):
    """code [B, D], place [B, F], patch [B, K, P] to [B, 2]: the sign logit and the logit of |d| / r."""

    def __init__(self, code, place, patch, local, patch_widths, head_widths):
        super().__init__()
        self.register_buffer("shift", torch.zeros(place))
        self.register_buffer("factor", torch.ones(place))
        self.point = nn.Sequential()
        pooled = 0
        if local:
            self.point = rows(patch, patch_widths)
            pooled = 2 * patch_widths[-1]
        self.head = rows(code + place + pooled, head_widths)
        # What is known of the place goes straight to the sign too: near a wall or a roof that was seen it is as sharp as
        # the vote, which the features behind two layers are not.
        self.sign = nn.Linear(head_widths[-1] + place, 1)
        self.distance = nn.Linear(head_widths[-1], 1)

    def forward(self, code, place, patch):
        return self.answers(code, (place - self.shift) * self.factor, patch)

    def answers(self, code, place, patch, pool=None):
        """The answers [B, 2] from a place that is scaled already; `pool` stands in for `pooled`."""
        parts = [code, place]
        if len(self.point) > 0:
            count, neighbours, channels = patch.shape
            # One matrix product over all the neighbours: a batched 1×1 convolution is slower everywhere.
            features = self.point(patch.reshape(count * neighbours, channels))
            parts += (pool or pooled)(features.reshape(count, -1), neighbours)
        hidden = self.head(torch.cat(parts, dim=1))
        return torch.cat([self.sign(torch.cat([hidden, place], dim=1)), self.distance(hidden)], dim=1)

    def standardise(self, place):
        """Fix mean and spread of the place channels; x, y, z and flags that do not vary keep their scale."""
        spread, mean = torch.std_mean(place, dim=0, unbiased=False)
        self.shift.copy_(mean)
        # Mirroring and turning must treat x and y alike.
        self.shift[:2] = 0.0
        spread[:2] = place[:, :2].square().mean().sqrt()
        self.factor.copy_(torch.where(spread > 1e-6, 1.0 / spread.clamp(min=0.02), torch.ones_like(spread)))


def pooled(features, neighbours):
    """Maximum and mean [B, W] over the neighbours of features [B, K·W]."""
    features = features.reshape(features.shape[0], neighbours, -1)
    return [features.amax(dim=1), features.mean(dim=1)]


def rows(inputs, widths):
    """Fully connected layers with ReLU on rows [N, inputs]."""
    layers = []
    for width in widths:
        layers += [nn.Linear(inputs, width), nn.ReLU()]
        inputs = width
    return nn.Sequential(*layers)
