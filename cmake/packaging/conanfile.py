"""Conan 2 recipe: `conan create cmake/packaging` in a clone or an unpacked archive builds its libraries."""
import os
import re

from conan import ConanFile
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load


class Tapestry(ConanFile):
    name = "tapestry"
    description = "Differentiable rendering and object detectors on one reverse-mode tape"
    license = "MIT"
    topics = ("automatic-differentiation", "differentiable-rendering", "object-detection")
    package_type = "static-library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"jpeg": [True, False]}
    default_options = {"jpeg": True}

    def _root(self):
        return os.path.join(self.recipe_folder, os.pardir, os.pardir)

    def set_version(self):
        header = load(self, os.path.join(self._root(), "include/tapestry/version.hpp"))
        self.version = re.search('TAPESTRY_VERSION_TEXT "(.+)"', header)[1]

    def export_sources(self):
        for pattern in ("CHANGELOG.md", "CMakeLists.txt", "LICENSE", "README.md", "cmake/*", "docs/*", "examples/tour/*",
                        "include/*"):
            copy(self, pattern, self._root(), self.export_sources_folder)

    def layout(self):
        self.folders.root = os.path.join(os.pardir, os.pardir)
        cmake_layout(self)

    def requirements(self):
        for library in ("eigen/3.4.0", "xtensor/0.24.7", "stb/cci.20230920", "protozero/1.7.1", "nlohmann_json/3.11.3"):
            self.requires(library, transitive_headers=True)
        self.requires("zlib/[>=1.2.11 <2]", transitive_headers=True)
        if self.options.jpeg:
            self.requires("libjpeg-turbo/[>=2.1 <4]", transitive_headers=True)

    def validate(self):
        check_min_cppstd(self, 20)

    def generate(self):
        CMakeDeps(self).generate()
        toolchain = CMakeToolchain(self)
        for option in ("TAPESTRY_BUILD_TESTS", "TAPESTRY_BUILD_EXAMPLES"):
            toolchain.cache_variables[option] = False
        toolchain.cache_variables["CMAKE_DISABLE_FIND_PACKAGE_turbojpeg"] = not self.options.jpeg
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()

    def package_info(self):  # consumers find what Tapestry installs for CMake itself
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = ["share/cmake/tapestry"]
        self.cpp_info.libs = ["tapestry_laboratory", "tapestry", "tapestry_float"]
        self.cpp_info.system_libs = ["pthread"]
