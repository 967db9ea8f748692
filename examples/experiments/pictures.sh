#!/usr/bin/env bash
# pictures.sh FOLDER: makes the pictures of README.md and docs/GALLERY.md in a new FOLDER by the commands of that page, in some
# minutes. Needs the programs that examples/run.sh builds, or others in BUILD.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
PATH=${BUILD:-$root/build/release}/examples:$PATH
mkdir "$1" && cd "$1"
set -x
source <(sed -n 's/^    //p' "$root/docs/GALLERY.md")
