#!/usr/bin/env bash
# run_in_fresh_folder.sh FOLDER SCRIPT ARGUMENT...: empties FOLDER and runs SCRIPT in it.
set -eu
folder=$1
script=$2
shift 2
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
exec bash "$script" "$@"
