# Steps of an experiment, each done once: to be sourced by the scripts beside it, after they set
#   output   folder for everything
#   common   array: options of camouflage for every run
#   further  array: weights of further detectors
#   seeds    array: seeds of every camouflage
#   draws    draws of matched noise
#   quick    array: (--quick) or ()
#   plain_of  the camouflage beside which random and plain colours are measured
#   command_line  words that make the tables again, shown with them
# In the environment: PROGRAMS, their folder; LAUNCH, words before camouflage and evaluate, such as "mpirun -n 4 --bind-to none".
export LC_ALL=C  # numbers with points
programs=${PROGRAMS:-$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)/build/release/examples}
read -ra launch <<<"${LAUNCH:-}"
child=
[ -x "$programs/tabulate" ] || { echo "error: $programs/tabulate is not built; cmake --build --preset release" >&2; exit 2; }

# Ends with an exit status of the programs.
fail() { # STATUS WORDS
  echo "error: $2" >&2
  exit "$1"
}

# Claims the output folder by io::RunLock's lock, as the programs do, until the script ends in any way.
claim() {
  mkdir -p "$output" && [ -w "$output" ] || fail 5 "$output: cannot write there"
  while true; do
    exec {lock}<>"$output/.lock"
    flock -n "$lock" || fail 7 "$output: folder is in use by $(cat "$output/.lock")"
    [ ! "/proc/self/fd/$lock" -ef "$output/.lock" ] || break # else its owner has deleted it
    exec {lock}>&-
  done
  trap 'rm -f "$output/.lock"' EXIT
  trap 'stop HUP' HUP
  trap 'stop INT' INT
  trap 'stop TERM' TERM
  echo "process $$ on $(hostname)" >"$output/.lock" || true # for people alone
}

# Stops the program that runs, which saves what it has, and the script.
stop() { # SIGNAL
  trap '' HUP INT TERM
  [ -z "$child" ] || { kill "$child" && wait "$child"; } 2>/dev/null || true
  exit $((128 + $(kill -l "$1")))
}

# Runs a program, whose words go to a file. It does not hold the script's lock, but locks what it writes itself.
run() { # FILE COMMAND...
  local status=0
  "${@:2}" >"$1" {lock}>&- &
  child=$!
  wait "$child" || status=$?
  child=
  [ "$status" = 0 ] || exit "$status"
}

# Prints the files that the programs have read so far, by their ledgers: lines of SHA-256 and path.
ledger() {
  find "$output" -mindepth 2 -maxdepth 3 \( -name manifest.json -o -name settings.json \) -exec cat {} + |
    sed -nE '/^ *"path": "/{s/^ *"path": "(.*)",?$/\1/;h;}
      /^ *"sha256": "/{s/^ *"sha256": "([0-9a-f]*)",?$/\1/;G;s/\n/  /p;}' | sort -u
}

# Refuses steps that have read different files of one name.
require_one_ledger() {
  local twice
  twice=$(ledger | awk '{ path = substr($0, 67); if (path in hash) { if (!found++) print path " was read with SHA-256 " substr(hash[path], 1, 16) \
    " and with " substr($1, 1, 16) } hash[path] = $1 }')
  [ -z "$twice" ] || fail 7 "$output: its steps do not go together: $twice"
}

# Refuses to continue if a file has changed since it was read.
require_same_inputs() {
  local changed
  changed=$(ledger | sha256sum --check --quiet --ignore-missing 2>/dev/null | sed -n '1s/: FAILED.*$//p') || true
  [ -z "$changed" ] || fail 7 "$output: $changed has changed since it was read (SHA-256 $(ledger | grep -F "  $changed" | cut -c 1-16), found $(
    sha256sum <"$changed" | cut -c 1-16)); put it back, or give another folder"
}

# Claims the output folder and notes its settings; refuses a folder with other settings or inputs.
settle() { # SETTINGS
  claim
  [ -e "$output/settings" ] || { printf '%s\n' "$1" >"$output/settings.part" && mv "$output/settings.part" "$output/settings"; } ||
    fail 5 "$output/settings: cannot write"
  [ "$(cat "$output/settings")" = "$1" ] ||
    fail 7 "$output was begun with other settings: $(cat "$output/settings"); found $1"
  require_one_ledger
  require_same_inputs
}

# Optimises a camouflage with each seed, in $output/runs/NAME-SEED. Finished steps are not repeated; interrupted ones
# continue. Its own options replace common ones. Random and plain colours are left to measure().
optimise() { # NAME OPTIONS...
  local name=$1 seed folder resume word is_kept=yes options=()
  shift
  for word in "${common[@]}"; do
    case $word in --*) [[ " $* " == *" $word "* ]] && is_kept=no || is_kept=yes ;; esac
    [ $is_kept = no ] || options+=("$word")
  done
  for seed in "${seeds[@]}"; do
    folder=$output/runs/$name-$seed resume=()
    [ ! -e "$folder/metrics.json" ] || continue
    [ ! -e "$folder/manifest.json" ] || resume=(--resume)
    mkdir -p "$output/runs"
    run "$folder.txt" "${launch[@]}" "$programs/camouflage" "${options[@]}" "$@" --controls matched --seed "$seed" --output "$folder" "${resume[@]}"
    require_one_ledger
  done
}

# Measures a run by a protocol, in $output/measured/PROTOCOL-NAME. Random and plain colours are measured with the first seed
# of one camouflage alone, $plain_of, since they are the same beside all.
measure() { # PROTOCOL NAME RUN OPTIONS...
  local folder=$output/measured/$1-$2 controls=matched
  [[ "$3" != "$output/runs/$plain_of-${seeds[0]}" || "$2" == *-train ]] || controls=all
  [ ! -e "$folder/cost.json" ] || return 0
  mkdir -p "$output/measured"
  run "$folder.txt" "${launch[@]}" "$programs/evaluate" --run "$3" --protocol "$1" --noise-draws "$draws" --controls $controls "${quick[@]}" \
    "${@:4}" --output "$folder"
  require_one_ledger
}

# Measures all seeds of a camouflage on photographs, with all detectors.
measure_photographs() { # NAME PROTOCOL OPTIONS...
  local seed
  for seed in "${seeds[@]}"; do
    measure "$2" "$1-$seed" "$output/runs/$1-$seed" ${further[@]:+--further-weights "${further[@]}"} "${@:3}"
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
  run "$output/$1.txt" "$programs/tabulate" --output "$output/tables" --name "$1" --title "$2" --command "$command_line" "${@:3}"
  echo "$2: $output/tables/$1.md"
}
