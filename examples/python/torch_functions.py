"""A detector and a painted mesh of Tapestry as functions of PyTorch, with gradients."""
import torch


class Logits(torch.autograd.Function):
    """logits = Logits.apply(detector, pictures), of a tapestry.Detector and pictures [N, height, width, 3]."""

    @staticmethod
    def forward(context, detector, pictures):
        context.run = detector.forward(pictures.detach().cpu().numpy())
        return tuple(torch.from_numpy(logits).to(pictures) for logits in context.run.logits)

    @staticmethod
    def backward(context, *adjoints):
        gradient = context.run.pull_back([adjoint.cpu().numpy() for adjoint in adjoints])
        return None, torch.from_numpy(gradient).to(adjoints[0])


class Picture(torch.autograd.Function):
    """picture = Picture.apply(view, texels), of a tapestry.View and texels [texel_count, 3]."""

    @staticmethod
    def forward(context, view, texels):
        context.view = view
        return torch.from_numpy(view.render(texels.detach().cpu().numpy())).to(texels)

    @staticmethod
    def backward(context, adjoint):
        return None, torch.from_numpy(context.view.pull_back(adjoint.cpu().numpy())).to(adjoint)
