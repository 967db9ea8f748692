#!/usr/bin/env bash
# arm64_libraries.sh FOLDER: unpacks the libraries that a build for arm64 links with, from Debian, into the folder, not into the
# system; once.
set -euo pipefail
[ ! -d "$1" ] || exit 0
mkdir -p "$1.lists/partial" "$1.part"
cd "$1.lists"
apt=(apt-get --quiet --quiet -o APT::Architectures::=arm64 -o Dir::State::lists="$PWD" -o Dir::Cache="$PWD"
     -o APT::Sandbox::User="$(id -un)")
"${apt[@]}" update
"${apt[@]}" download {zlib1g,zlib1g-dev}:arm64
cd - >/dev/null
for package in "$1.lists"/*.deb; do dpkg-deb --extract "$package" "$1.part"; done
mv "$1.part" "$1"
