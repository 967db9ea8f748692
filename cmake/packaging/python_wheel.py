"""Makes the wheel of the Python package, as PEP 517 has it: CMake builds the module, and the same sources give the same bytes.

It needs a compiler, CMake, Python's headers and pybind11, and no other Python package.
"""
import base64
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import zipfile

root = pathlib.Path(__file__).resolve().parents[2]
version = re.search(r'TAPESTRY_VERSION_TEXT "(.+)"', (root / "include/tapestry/version.hpp").read_text())[1]
distribution = f"tapestry-{version}"
info = f"{distribution}.dist-info"
# NumPy is no requirement, so that pip needs no network where Debian has it; without it the package says so.
metadata = f"""Metadata-Version: 2.1
Name: tapestry
Version: {version}
Summary: Detectors, a differentiable rasteriser and full-coverage camouflage for research on robustness
License: MIT
Requires-Python: >=3.9
Provides-Extra: numpy
Requires-Dist: numpy; extra == "numpy"
"""


def tag():
    """The platforms of the module: every Linux with this C library or a newer one, as the wheel brings all else."""
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    libc = os.confstr("CS_GNU_LIBC_VERSION").split()[1] if "CS_GNU_LIBC_VERSION" in os.confstr_names else ""
    platform = sysconfig.get_platform().replace("linux", f"manylinux_{libc}", 1 if libc else 0)
    return f"{python}-{python}-" + re.sub("[-.]", "_", platform)


def libraries_of(module):
    """Shared libraries of the module that Linux may lack, and their licences, as members of the wheel."""
    everywhere = {"libc", "libm", "libstdc++", "libgcc_s", "libz", "libpthread", "libdl", "librt"}
    loaded = subprocess.run(["ldd", module], check=True, capture_output=True, text=True).stdout
    members = {}
    for name, path in re.findall(r"(\S+) => (\S+)", loaded):
        if name.split(".")[0] in everywhere or name.startswith("ld-"):
            continue
        members[f"tapestry/{name}"] = pathlib.Path(path).read_bytes()
        for licence in pathlib.Path("/usr/share/doc").glob(name.split(".")[0] + "[0-9]*/copyright"):
            members[f"{info}/LICENSE.{name}"] = licence.read_bytes()
    return members


def built_package():
    """Builds the package in build/python-…; returns its folder."""
    build = root / "build" / f"python-{sys.implementation.cache_tag}"
    if not shutil.which("cmake"):
        raise RuntimeError("Tapestry is built by CMake, which was not found. On Debian: .ci/packages python")
    generator = ["-G", "Ninja"] if shutil.which("ninja") and not (build / "Makefile").exists() else []
    subprocess.run(["cmake", "-S", root, "-B", build, *generator, "-DCMAKE_BUILD_TYPE=Release", "-DTAPESTRY_PYTHON=ON",
                    "-DTAPESTRY_BUILD_TESTS=OFF", "-DTAPESTRY_BUILD_EXAMPLES=OFF", "-DTAPESTRY_CCACHE=ON",
                    f"-DPython_EXECUTABLE={sys.executable}"], check=True)
    subprocess.run(["cmake", "--build", build, "--target", "tapestry_python", "--parallel", str(os.cpu_count())],
                   check=True)
    return build / "examples/python/tapestry"


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    folder = pathlib.Path(metadata_directory) / info
    folder.mkdir(exist_ok=True)
    (folder / "METADATA").write_text(metadata)
    return info


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    package = built_package()
    members = {f"tapestry/{path.name}": path.read_bytes() for path in package.iterdir() if path.is_file()}
    members.update(libraries_of(next(package.glob("_tapestry*.so"))))
    members[f"{info}/LICENSE"] = (root / "LICENSE").read_bytes()
    members[f"{info}/METADATA"] = metadata.encode()
    members[f"{info}/WHEEL"] = (f"Wheel-Version: 1.0\nGenerator: tapestry {version}\nRoot-Is-Purelib: false\n"
                                f"Tag: {tag()}\n").encode()
    record = ""
    for name, content in sorted(members.items()):
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        record += f"{name},sha256={digest},{len(content)}\n"
    members[f"{info}/RECORD"] = (record + f"{info}/RECORD,,\n").encode()
    name = f"{distribution}-{tag()}.whl"
    with zipfile.ZipFile(pathlib.Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        for member, content in sorted(members.items()):
            entry = zipfile.ZipInfo(member)  # of 1980, whenever it is written
            entry.external_attr = 0o644 << 16
            wheel.writestr(entry, content, zipfile.ZIP_DEFLATED)
    return name


def build_sdist(sdist_directory, config_settings=None):
    name = f"{distribution}.tar.gz"
    subprocess.run(["git", "archive", f"--prefix={distribution}/", f"--add-virtual-file={distribution}/PKG-INFO:{metadata}",
                    "-o", pathlib.Path(sdist_directory).resolve() / name, "HEAD"], cwd=root, check=True)
    return name
