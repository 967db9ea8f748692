"""Detectors, meshes, compositing, losses and camouflages, with gradients, as functions of NumPy arrays."""
try:
    import numpy  # noqa: F401, which the module needs once it is called
except ImportError as error:
    raise ImportError("tapestry needs NumPy: apt install python3-numpy, or pip install numpy") from error
from ._tapestry import *  # noqa: F401, F403
from ._tapestry import __version__, png  # noqa: F401


class Picture:
    """A picture [H, W, 3], bytes or floating-point RGB in [0, 1], that notebooks show."""

    def __init__(self, array):
        """Takes the array as it is."""
        self.array = array

    def _repr_png_(self):
        return png(self.array)

    def save(self, path):
        """Writes the picture as a PNG file, and returns itself."""
        with open(path, "wb") as file:
            file.write(self._repr_png_())
        return self
