"""A detector, its adversarial loss and a painted mesh of Tapestry as functions of PyTorch, with gradients."""
import torch


class Logits(torch.autograd.Function):
    """logits = Logits.apply(detector, pictures), of a tapestry.Detector and pictures [N, height, width, 3]."""

    @staticmethod
    def forward(context, detector, pictures):
        context.run = detector.forward(pictures.detach().cpu().numpy())
        return tuple(torch.tensor(logits).to(pictures) for logits in context.run.logits)

    @staticmethod
    def backward(context, *adjoints):
        gradient = context.run.pull_back([adjoint.cpu().numpy() for adjoint in adjoints])
        return None, torch.from_numpy(gradient).to(adjoints[0])


class Adversarial(torch.autograd.Function):
    """total = Adversarial.apply(detector, targets, loss, *logits), as Detector.adversarial."""

    @staticmethod
    def forward(context, detector, targets, loss, *logits):
        terms, adjoints = detector.adversarial([each.detach().cpu().numpy() for each in logits], targets, loss)
        context.adjoints = [torch.from_numpy(adjoint).to(logits[0]) for adjoint in adjoints]
        return logits[0].new_tensor(terms["total"])

    @staticmethod
    def backward(context, adjoint):
        return None, None, None, *(adjoint * each for each in context.adjoints)


class Picture(torch.autograd.Function):
    """picture = Picture.apply(view, texels), of a tapestry.View and texels [T, 3] in its mesh's space."""

    @staticmethod
    def forward(context, view, texels):
        context.view = view
        return torch.from_numpy(view.render(texels.detach().cpu().numpy())).to(texels)

    @staticmethod
    def backward(context, adjoint):
        return None, torch.from_numpy(context.view.pull_back(adjoint.cpu().numpy())).to(adjoint)
