#!/usr/bin/env bash
# The Debian packages that cpack makes of the build folder: their bytes, what is in them, what lintian finds, and that they are
# of use where they are unpacked.
source "$(dirname "$0")/support.sh"
build=$programs/..
command -v cpack dpkg-deb objdump pkg-config >/dev/null && [ -e "$build/CPackConfig.cmake" ] || exit 77
names="camouflage convert_weights detect evaluate harden make_dataset render train_detector train_segmenter"
for name in $names; do [ -x "$programs/$name" ] || exit 77; done
version=$(sed -n 's/.*TAPESTRY_VERSION_TEXT "\(.*\)"/\1/p' "$sources/include/tapestry/version.hpp")

expect_exit 0 "packing" cpack --config "$build/CPackConfig.cmake" -B "$PWD/packed"
(umask 077 && TZ=Asia/Tokyo LC_ALL=C.UTF-8 cpack --config "$build/CPackConfig.cmake" -B "$PWD/again" >/dev/null)
for package in libtapestry-dev tapestry-tools python3-tapestry; do
  [ $package != python3-tapestry ] || ls "$programs"/python/tapestry/_tapestry*.so >/dev/null 2>&1 || continue
  file=${package}_$version-1_$(dpkg --print-architecture).deb
  expect_same "packed/$file" "again/$file"
  expect_exit 0 "unpacking" dpkg-deb -x "packed/$file" root
  for name in copyright changelog.gz changelog.Debian.gz tapestry.spdx.json; do expect_file "root/usr/share/doc/$package/$name"; done
  dpkg-deb --ctrl-tarfile "packed/$file" | tar -xO ./md5sums | (cd root && md5sum --check --quiet) && pass || fail "$package: sums"
done
[ "${TAPESTRY_TESTS_LONG:-}" != ON ] || ! command -v lintian >/dev/null || expect_exit 0 "lintian" lintian --allow-root --fail-on error,warning packed/*.deb
dpkg-deb --info packed/tapestry-tools_*.deb >fields
grep -q "^ Version: $version-1$" fields && pass || fail "$(cat fields)"
for name in $names; do
  [ "$(root/usr/bin/$name --version)" = "$name (Tapestry) $version" ] && pass || fail "the packed $name does not start"
  gzip -t "root/usr/share/man/man1/$name.1.gz" && pass || fail "no page of $name"
  expect_file "root/usr/share/bash-completion/completions/$name"
done
grep -q 'MIT' root/usr/share/doc/tapestry-tools/copyright && pass || fail "the copyright names no licence"
# It depends on MPI if and only if a program in it does.
linked=$(objdump -p root/usr/bin/camouflage root/usr/bin/evaluate | grep -ic 'needed.*libmpi')
[ "$(grep -c '^ Depends:.*mpi' fields)" = $((linked > 0)) ] && pass || fail "$linked programs need MPI: $(grep Depends fields)"
! grep -q '^TAPESTRY_MPI:BOOL=OFF' "$build/CMakeCache.txt" || [ "$linked" = 0 ] && pass || fail "programs need MPI"
[ -e root/usr/bin/make_assets ] && fail "make_assets is packed" || pass
expect_exit 0 "what is bundled" root/usr/bin/detect root/usr/share/tapestry/assets/frames/test/000.npz
grep -q '^  car ' command.out && pass || fail "the packed detector finds no car"
[ ! -d root/usr/lib/python3 ] || PYTHONPATH=root/usr/lib/python3/dist-packages expect_exit 0 "the Python package" /usr/bin/python3 -Bc \
  'import tapestry, importlib.metadata as m; assert tapestry.__version__ == m.version("tapestry") and tapestry.Adam'
expect_exit 0 "links" cmake -DFOLDER=root/usr/share/doc/libtapestry-dev -P "$sources/tests/consumer/check_links.cmake"
grep -rlF "$sources" root >paths && fail "these name the folder of the sources: $(cat paths)" || pass

cat >main.cpp <<'END'
#include <cstdio>
#include <tapestry/autodiff.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/npy.hpp>

int main() {
  tapestry::Tape<double> tape;
  const auto scope = tape.activate();
  const auto x = tape.input(3.0);
  tape.reverse(x * x);
  std::printf("%.0f %.8s\n", x.adjoint(), tapestry::io::sha256("tapestry").c_str());
}
END
expected="6 $(printf tapestry | sha256sum | head -c 8)"
export PKG_CONFIG_PATH=$PWD/root/usr/share/pkgconfig
expect_exit 0 "pkg-config" pkg-config --print-errors --cflags --libs tapestry
read -ra flags <command.out
grep -q -- '-isystem ' command.out && fail "what is installed into /usr is put before the C library" || pass
expect_exit 0 "compiling by pkg-config" "${CXX:-g++}" -std=c++20 main.cpp "${flags[@]}" -o by_pkg_config
[ "$(./by_pkg_config)" = "$expected" ] && pass || fail "pkg-config's program says $(./by_pkg_config)"

cat >CMakeLists.txt <<'END'
cmake_minimum_required(VERSION 3.22)
project(user LANGUAGES CXX)
find_package(tapestry REQUIRED)
add_executable(by_find_package main.cpp)
target_link_libraries(by_find_package PRIVATE tapestry::compiled)
END
expect_exit 0 "find_package" cmake -B user -DCMAKE_PREFIX_PATH="$PWD/root/usr"
grep -q "tapestry_DIR:PATH=$PWD/root" user/CMakeCache.txt && pass || fail "another Tapestry was found"
expect_exit 0 "compiling by find_package" cmake --build user
[ "$(user/by_find_package)" = "$expected" ] && pass || fail "find_package's program says $(user/by_find_package)"
finish
