"""torch_test.py ASSETS: a loss of texels by PyTorch's functions has the slope that differences have."""
import sys

import torch
import tapestry
from tapestry.torch_functions import Adversarial, Logits, Picture

assets = sys.argv[1]
detector = tapestry.Detector(assets + "/detector.weights", config=assets + "/detector.cfg")
car = tapestry.Mesh(assets + "/car_sedan.obj", material="body", rows=16, space="encoded")
frame = tapestry.Frame(assets + "/frames/test/027.npz")
view = tapestry.View(car, frame.camera, detector.height, detector.width, frame.light("encoded"))
behind = torch.tensor(frame.photograph) / 255 * (1 - torch.tensor(view.coverage)[..., None])


def loss(texels):
    pictures = (Picture.apply(view, texels) + behind)[None]
    return Adversarial.apply(detector, frame.label[None], "max_score", *Logits.apply(detector, pictures))


texels = torch.full((car.texel_count, 3), 0.5, requires_grad=True)
loss(texels).backward()
direction = texels.grad / texels.grad.norm()
with torch.no_grad():
    slope = (loss(texels + 0.01 * direction) - loss(texels - 0.01 * direction)) / 0.02
assert abs(slope - texels.grad.norm()) < 0.03 * texels.grad.norm(), (slope, texels.grad.norm())
