# Steps of an experiment, each done once: to be sourced by the scripts beside it, after they set
#   output   folder for everything
#   common   array: options of camouflage for every run
#   further  array: weights of further detectors
#   seeds    array: seeds of every camouflage
#   draws    draws of matched noise
#   quick    array: (--quick) or ()
#   command_line  words that make the tables again, shown with them
# In the environment: LAUNCH, words before camouflage and evaluate, such as "mpirun -n 4 --bind-to none".
export LC_ALL=C  # numbers with points
programs=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)/build/release/examples
read -ra launch <<<"${LAUNCH:-}"
[ -x "$programs/tabulate" ] || { echo "error: $programs/tabulate is not built; cmake --build --preset release" >&2; exit 2; }

# Notes the settings of an output folder, and refuses others there.
settle() { # SETTINGS
  mkdir -p "$output"
  [ -e "$output/settings" ] || { printf '%s\n' "$1" >"$output/settings.part" && mv "$output/settings.part" "$output/settings"; }
  [ "$(cat "$output/settings")" = "$1" ] ||
    { printf 'error: %s was begun with other settings: %s; found %s\n' "$output" "$(cat "$output/settings")" "$1" >&2; exit 7; }
}

# Optimises a camouflage with each seed, in $output/runs/NAME-SEED. What is there is not done again, and what was interrupted
# goes on.
optimise() { # NAME OPTIONS...
  local name=$1 seed run resume
  shift
  for seed in "${seeds[@]}"; do
    run=$output/runs/$name-$seed resume=()
    [ ! -e "$run/report.html" ] || continue
    [ ! -e "$run/manifest.json" ] || resume=(--resume)
    mkdir -p "$output/runs"
    "${launch[@]}" "$programs/camouflage" "${common[@]}" "$@" --seed "$seed" --output "$run" "${resume[@]}" >"$run.txt"
  done
}

# Measures a run by a protocol, in $output/measured/PROTOCOL-NAME.
measure() { # PROTOCOL NAME RUN OPTIONS...
  local folder=$output/measured/$1-$2
  [ ! -e "$folder/cost.json" ] || return 0
  mkdir -p "$output/measured"
  "${launch[@]}" "$programs/evaluate" --run "$3" --protocol "$1" --noise-draws "$draws" "${quick[@]}" "${@:4}" \
    --output "$folder" >"$folder.txt"
}

# Measures all seeds of a camouflage on photographs, with all detectors.
measure_photographs() { # NAME PROTOCOL OPTIONS...
  local seed
  for seed in "${seeds[@]}"; do
    measure "$2" "$1-$seed" "$output/runs/$1-$seed" --controls matched ${further[@]:+--further-weights "${further[@]}"} "${@:3}"
  done
}

# Words of a row: the folders of a camouflage's seeds. Its label may differ from its name.
row() { # PROTOCOL [LABEL:]NAME [SUFFIX...]
  local words="${2%%:*}=" folder=$output/measured/$1-${2##*:} seed suffix
  for seed in "${seeds[@]}"; do
    for suffix in "${@:3}"; do words+=$folder-$seed$suffix,; done
    [ $# -gt 2 ] || words+=$folder-$seed,
  done
  echo "${words%,}"
}

# Makes one table of rows, in $output/tables.
tabulate() { # NAME TITLE ROW...
  "$programs/tabulate" --output "$output/tables" --name "$1" --title "$2" --command "$command_line" "${@:3}" >"$output/$1.txt"
  echo "$2: $output/tables/$1.md"
}
