# What tests/lint/includes and tests/lint/tidy share: which files a check has found clean is kept beside the compiler's
# cache, so that only what has changed since is checked. Sourced, in the root; build/lint is configured.
#
#   changed                files changed since INFUSE_LINT_BASE (HEAD~20) or not committed, the latest first
#   unchecked CHECK        those of the files on standard input that it has not found clean as they are now
#   check_all CHECK SECONDS   runs check_CHECK FILE LIST for each file on standard input; LIST: what it depends on

store=${XDG_CACHE_HOME:-$HOME/.cache}/infuse/lint
work=$PWD/build/lint/checks
mkdir -p "$work"

changed() {
  local base=${INFUSE_LINT_BASE:-HEAD~20}
  git rev-parse --verify --quiet "$base" >/dev/null || base=$(git rev-list --max-parents=0 HEAD | tail -n 1)
  { git diff --name-only HEAD; git log --name-only --format= "$base.."; } | awk 'NF && !seen[$0]++'
}

# Every file and its content's id, as git has it or as it lies there.
git ls-files -s | awk '{ print $4, $2 }' >"$work/ids"
git ls-files -mo --exclude-standard '*.cpp' '*.hpp' .clang-tidy | while read -r file; do
  [[ ! -e $file ]] || echo "$file $(git hash-object "$file")"
done >>"$work/ids"

# FILE<tab>COMMAND of everything that is compiled.
awk -v root="$PWD/" '
  /^  "command": "/ { sub(/^  "command": "/, ""); sub(/",$/, ""); gsub(/\\"/, "\""); gsub(/\\\\/, "\\"); command = $0 }
  /^  "file": "/ { sub(/^  "file": "/, ""); sub(/".*/, ""); sub(root, ""); print $0 "\t" command }
' build/lint/compile_commands.json | sort -u -t $'\t' -k 1,1 >"$work/commands"

record_of() { echo "$store/$1/${2//\//%}"; } # CHECK FILE

unchecked() { # CHECK
  mkdir -p "$store/$1"
  awk -v folder="$store/$1/" '
    FILENAME != "-" { id[$1] = $2; next }
    {
      record = $0; gsub(/\//, "%", record); record = folder record
      clean = 0
      while ((getline line < record) > 0) {
        split(line, field, " ")
        clean = field[1] in id && id[field[1]] == field[2]
        if (!clean) break
      }
      close(record)
      if (!clean) print
    }' "$work/ids" -
}

check_file() { # CHECK FILE
  local list record; list=$(mktemp) record=$(record_of "$1" "$2")
  if "check_$1" "$2" "$list"; then
    tr -s ' \\\n' '\n' <"$list" | sed "s|^$PWD/||" | sort -u |
      awk 'FILENAME != "-" { id[$1] = $2; next } $1 in id { print $1, id[$1] }' "$work/ids" - >"$record.$$"
    mv "$record.$$" "$record"
  else
    echo "$2" >>"$work/failed"
  fi
  rm -f "$list"
  echo "$2" >>"$work/done"
}

check_all() { # CHECK SECONDS
  local all=() code=0
  mapfile -t all
  : >"$work/done"; : >"$work/failed"
  export store work
  export -f record_of check_file "check_$1"
  ((${#all[@]} == 0)) || printf '%s\n' "${all[@]}" |
    timeout "$2" xargs -P "$(nproc)" -I {} bash -c 'check_file "$@"' check "$1" {} || code=$?
  ((code == 0 || code == 124)) || exit "$code"
  echo "$1: $(wc -l <"$work/done") of ${#all[@]} files checked, $(wc -l <"$work/failed") failed" >&2
  [[ ! -s $work/failed ]] || { cat "$work/failed" >&2; return 1; }
  ((code == 0)) || echo "$1: the rest was not reached within $2 s" >&2
  ((${#all[@]} == 0)) || [[ -s $work/done ]] || { echo "$1: nothing was checked" >&2; return 1; }
}
