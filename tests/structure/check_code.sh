#!/usr/bin/env bash
# check_code.sh FOLDER: prints functions of more than 40 lines below FOLDER/include and FOLDER/examples, names that two
# types of FOLDER/include have, and unconstrained parameters called T in the rooms above the tape. Exits with 1 if there
# are any. Sources are as clang-format leaves them.
set -euo pipefail
cd "$1"

# A function begins where a line with a parameter list, or the last initialiser of a constructor, ends with "{". Raw strings
# are passed over.
long_functions='
  function code(line) {
    gsub(/\\./, "", line); gsub(/"[^"]*"/, "", line); gsub(/\047[^\047]*\047/, "", line); sub(/\/\/.*/, "", line)
    return line
  }
  FNR == 1 { depth = 0; is_raw = 0 }
  is_raw { if (/\)[a-z]*"/) is_raw = 0; next }
  /R"[a-z]*\(/ && !/\)[a-z]*"/ { is_raw = 1 }
  depth == 0 && /[^ ].*\{$/ && /\)|^ *:/ &&
    !/^ *(namespace|class|struct|enum|union|if|for|while|switch|do|else|extern|case|default|return|requires)([^a-z_]|$)/ &&
    !/^ *}/ && !/= \{$/ && !/\[[^]]*\]\(/ && !/\[[&=]/ { first = FNR }
  first {
    line = code($0)
    depth += gsub(/\{/, "{", line) - gsub(/\}/, "}", line)
    if (depth <= 0) {
      if (FNR - first - 1 > 40) { print FILENAME ":" first ": a function of " FNR - first - 1 " lines"; found = 1 }
      first = depth = 0
    }
  }
  END { exit found }'

# Types at the level of a namespace. Vocabularies of functions, whose types have the functions own names in each, are left out.
type_names='
  /^(template <.*> )?(class|struct|enum class|concept) [A-Za-z0-9_]+( |$)/ && (!/;/ || /[{]/) {
    line = $0
    sub(/^template <.*> /, "", line); sub(/^(class|struct|enum class|concept) /, "", line); sub(/[^A-Za-z0-9_].*/, "", line)
    if (line in place && place[line] != FILENAME) { print FILENAME ": " line " is also in " place[line]; found = 1 }
    place[line] = FILENAME
  }
  END { exit found }'

# A scalar of a picture or a network is called T and is std::floating_point; other types have names of their own. The tape's
# own T may also be a dual number.
unconstrained='/template <(.*, )?class T[>,]/ { print FILENAME ":" FNR ": T is not std::floating_point"; found = 1 } END { exit found }'

status=0
mapfile -t sources < <(find include examples -name '*.hpp' -o -name '*.cpp' -o -name '*.inl' | sort)
awk "$long_functions" "${sources[@]}" || status=1
mapfile -t headers < <(find include -name '*.hpp' -o -name '*.inl' | grep -vE '/functions/|_functions\.hpp$' | sort)
awk "$type_names" "${headers[@]}" || status=1
mapfile -t above < <(printf '%s\n' /dev/null "${headers[@]}" | grep -vE 'include/tapestry/(autodiff|core)/')
awk "$unconstrained" "${above[@]}" || status=1
exit "$status"
