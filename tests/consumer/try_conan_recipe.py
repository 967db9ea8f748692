"""try_conan_recipe.py SOURCES WORK_FOLDER: runs the Conan recipe's methods in Conan's order, with stand-ins of its tools that do
what its documentation says. What the recipe packages is left in WORK_FOLDER/package; its libraries are the machine's."""
import fnmatch
import os
import pathlib
import runpy
import shutil
import subprocess
import sys
import types

sources, work = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
shutil.rmtree(work, ignore_errors=True)
variables, requirements, properties = {}, [], {}


class ConanFile:
    def __init__(self):
        self.folders, self.options = types.SimpleNamespace(root=None), types.SimpleNamespace(**self.default_options)
        self.cpp_info = types.SimpleNamespace(set_property=properties.__setitem__)

    def requires(self, reference, **traits):
        requirements.append(reference.split("/")[0])


class CMakeToolchain:
    def __init__(self, recipe):
        self.cache_variables = {}

    def generate(self):
        variables.update(self.cache_variables)


class CMakeDeps(CMakeToolchain):
    pass


class CMake:
    build_folder = work / "build/source/build/Release"

    def __init__(self, recipe):
        self.source = recipe.source_folder

    def run(self, *arguments):
        subprocess.run(["cmake", *arguments], check=True)

    def configure(self):
        values = [f"-D{name}={'ON' if value is True else 'OFF' if value is False else value}" for name, value in variables.items()]
        self.run("-S", self.source, "-B", self.build_folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DTAPESTRY_CCACHE=ON",
                 f"-DCMAKE_INSTALL_PREFIX={work / 'package'}", *values)

    def build(self):
        self.run("--build", self.build_folder)

    def install(self):
        self.run("--install", self.build_folder)


def copy(recipe, pattern, src, dst):
    for folder, _, names in os.walk(src):
        for name in names:
            path = os.path.relpath(os.path.join(folder, name), src)
            if fnmatch.fnmatch(path, pattern):
                target = pathlib.Path(dst) / path
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(os.path.join(src, path), target)


def module(name, **members):
    sys.modules[name] = types.ModuleType(name)
    vars(sys.modules[name]).update(members)


module("conan", ConanFile=ConanFile)
module("conan.tools")
module("conan.tools.build", check_min_cppstd=lambda recipe, standard: None)
module("conan.tools.cmake", CMake=CMake, CMakeDeps=CMakeDeps, CMakeToolchain=CMakeToolchain, cmake_layout=lambda recipe: None)
module("conan.tools.files", copy=copy, load=lambda recipe, path: pathlib.Path(path).read_text())
recipe = runpy.run_path(str(sources / "cmake/packaging/conanfile.py"))["Tapestry"]()
recipe.recipe_folder = str(sources / "cmake/packaging")
recipe.export_sources_folder = recipe.source_folder = str(work / "build/source")
for step in ("set_version", "export_sources", "layout", "requirements", "validate", "generate", "build", "package", "package_info"):
    getattr(recipe, step)()
assert recipe.version in (sources / "include/tapestry/version.hpp").read_text()
assert set(requirements) == {"eigen", "xtensor", "stb", "protozero", "nlohmann_json", "zlib", "libjpeg-turbo"}, requirements
for folder in recipe.cpp_info.builddirs:
    assert (work / "package" / folder / "tapestryConfig.cmake").exists(), folder
for library in recipe.cpp_info.libs:
    assert list((work / "package").glob(f"lib*/**/lib{library}.a")), library
