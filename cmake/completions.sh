#!/usr/bin/env bash
# completions.sh PROGRAM SHARE: writes the completion of a program for bash, zsh and fish below SHARE, from what its --help
# prints (form_help() of examples/programs/shell/command_line.cpp). With TAPESTRY_MARKED_HELP the words that an option takes
# stand in braces there. Options without words take folders where their text begins so, numbers by their type, or files.
set -euo pipefail
program=$1
name=$(basename "$program")
bash_folder=$2/bash-completion/completions
zsh_folder=$2/zsh/site-functions
fish_folder=$2/fish/vendor_completions.d
case $2 in */usr/share | /usr/share) zsh_folder=$2/zsh/vendor-completions ;; esac  # where Debian's zsh looks
mkdir -p "$bash_folder" "$zsh_folder" "$fish_folder"
version=$("$program" --version)
TAPESTRY_MARKED_HELP=1 "$program" --help | awk -v name="$name" -v version="$version" -v to_bash="$bash_folder/$name" \
  -v to_zsh="$zsh_folder/_$name" -v to_fish="$fish_folder/$name.fish" '
  # An option begins in column 3 and its text in column 27, or in the next line.
  function begin(head, text) {
    count = split(head, word, " ")
    short[++n] = word[1] ~ /^-.,/ ? substr(word[1], 1, 2) : ""
    long[n] = word[1]
    sub(/^-.,/, "", long[n])
    type[n] = count > 1 && word[2] ~ /^(TEXT|UINT|INT|FLOAT)/ ? word[2] : ""
    several[n] = head ~ / \.\.\./
    about[n] = text
  }
  /^Usage: / { takes_files = /\.\.\.\]?$/; next }
  /^(Examples|Exit status):$/ { ended = 1 }  # awk reads on, so that the program can write all of it
  ended { next }
  /^  -/ { wide = substr($0, 26, 1) != " "; begin(wide ? $0 : substr($0, 1, 26), wide ? "" : substr($0, 27)); next }
  /^ *[^ ]/ && n && !/^[A-Z]/ && !/^  [^ ]/ { sub(/^ +/, ""); about[n] = about[n] (about[n] == "" ? "" : " ") $0 }
  function words_of(text,    list) {
    while (match(text, /\{[^}]*\}/)) {
      list = list (list == "" ? "" : " ") substr(text, RSTART + 1, RLENGTH - 2)
      text = substr(text, RSTART + RLENGTH)
    }
    return list
  }
  function kind_of(i) {
    if (type[i] == "") return "flag"
    if (words[i] != "") return about[i] ~ /JSON file|texture\.npz/ ? "word or file" : "word"
    if (type[i] !~ /^TEXT/) return "number"
    if (about[i] ~ /^(run )?folder/) return "folder"
    if (about[i] ~ /file|folder|picture|PNG|PDF|OBJ|ONNX|\.onnx|COCO|Darknet|one a line|painted mesh/) return "file"
    return "text"
  }
  function short_text(i, quote,    text) {
    text = about[i] ~ /^\{/ ? substr(long[i], 3) : about[i]
    gsub(/[{}\\"`$\[\]]/, "", text)
    if (match(text, /[:;.(]( |$)| \(/)) text = substr(text, 1, RSTART - 1)
    if (length(text) > 72) { text = substr(text, 1, 72); sub(/ [^ ]*$/, " ...", text) }
    gsub(/:/, "", text)
    gsub(/\x27/, quote, text)
    return text
  }
  function for_bash(    i, all, folders, others, many) {
    for (i = 1; i <= n; i++) {
      all = all (i > 1 ? " " : "") long[i] (short[i] == "" ? "" : " " short[i])
      if (several[i]) many = many " " long[i] " "
      if (kind[i] == "folder") folders = folders (folders == "" ? "" : " | ") long[i]
      if (kind[i] == "number" || kind[i] == "text") others = others (others == "" ? "" : " | ") long[i]
    }
    print "# Options of " version " with the words, folders and files that they take." >to_bash
    print "_tapestry_" name "() {" >to_bash
    print "  local current=$2 at=$((COMP_CWORD - 1))" >to_bash
    print "  [[ $current == = ]] && current=" >to_bash
    print "  [[ ${COMP_WORDS[at]} == = ]] && at=$((at - 1))  # --option=value" >to_bash
    print "  local option=${COMP_WORDS[at]}" >to_bash
    if (many != "") {
      print "  while [[ $option != -* ]] && ((at > 1)); do at=$((at - 1)) option=${COMP_WORDS[at]}; done" >to_bash
      print "  ((at < COMP_CWORD - 1)) && [[ ${COMP_WORDS[at + 1]} != = && \"" many "\" != *\" $option \"* ]] && option=" >to_bash
    }
    print "  case $option in" >to_bash
    for (i = 1; i <= n; i++)
      if (words[i] != "") print "    " long[i] ") COMPREPLY=($(compgen -W \"" words[i] "\" -- \"$current\")) ;;" >to_bash
    if (folders != "")
      print "    " folders ") mapfile -t COMPREPLY < <(compgen -d -- \"$current\"); compopt -o filenames 2>/dev/null ;;" >to_bash
    if (others != "") print "    " others ") compopt +o default 2>/dev/null ;;  # no files" >to_bash
    print "    *) [[ $current == -* ]] && COMPREPLY=($(compgen -W \"" all " \" -- \"$current\")) ;;" >to_bash
    print "  esac\n}\ncomplete -o default -F _tapestry_" name " " name >to_bash
  }
  function for_zsh(    i, what, names) {
    print "#compdef " name "\n# Options of " version " with the words, folders and files that they take.\n_arguments \\" >to_zsh
    for (i = 1; i <= n; i++) {
      what = kind[i] == "flag" ? "" : ":" substr(long[i], 3) ":"
      if (kind[i] == "word") what = what "(" words[i] ")"
      if (kind[i] == "word or file")
        what = what "{_alternative \"words:word:(" words[i] ")\" \"files:file:_files\"}"
      if (kind[i] == "folder") what = what "_files -/"
      if (kind[i] == "file") what = what "_files"
      if (kind[i] == "number" || kind[i] == "text") what = what " "
      names = short[i] == "" ? "\x27" (several[i] ? "*" : "") long[i] (kind[i] == "flag" ? "" : "=") : "{" short[i] "," long[i] "}\x27"
      print "  " names "[" short_text(i, "\x27\\\\\x27\x27") "]" what "\x27 \\" >to_zsh
    }
    print (takes_files ? "  \x27*:file:_files\x27" : "  && return") >to_zsh
  }
  function for_fish(    i, what) {
    print "# Options of " version " with the words, folders and files that they take." >to_fish
    if (!takes_files) print "complete -c " name " -f" >to_fish
    for (i = 1; i <= n; i++) {
      what = kind[i] == "flag" ? "" : kind[i] == "file" || kind[i] == "word or file" ? " -r -F" : " -x"
      if (words[i] != "") what = what " -a \x27" words[i] "\x27"
      if (kind[i] == "folder") what = what " -a \x27(__fish_complete_directories)\x27"
      print "complete -c " name (short[i] == "" ? "" : " -s " substr(short[i], 2)) " -l " substr(long[i], 3) what \
            " -d \x27" short_text(i, "\\\\\x27") "\x27" >to_fish
    }
  }
  END {
    for (i = 1; i <= n; i++) { words[i] = words_of(about[i]); kind[i] = kind_of(i) }
    for_bash()
    for_zsh()
    for_fish()
  }'
