#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What thew --completion offers in bash, and in zsh and fish where they are: completion.sh THEW
set -euo pipefail
thew=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for shell in bash zsh fish; do "$thew" --completion $shell >"$work/$shell"; done
. "$work/bash"
failed=0
# offers "WORDS BEFORE" WORD EXPECTED...: of the completions of WORD
offers() {
  local before=($1) word=$2
  shift 2
  local COMP_WORDS=("${before[@]}" "$word") COMP_CWORD=${#before[@]}
  _thew thew "$word" "${before[-1]}"
  for expected; do
    [[ " ${COMPREPLY[*]} " == *" $expected "* ]] ||
      { echo "bash: ${before[*]} $word: \"${COMPREPLY[*]}\" lacks $expected"; failed=1; }
  done
  (($#)) || [[ -z ${COMPREPLY[*]} ]] || { echo "bash: ${before[*]}: offers ${COMPREPLY[*]}"; failed=1; }
}
offers "thew" "" bake render golden chart
offers "thew" "ba" bake
offers "thew" "--" --json --version --completion
offers "thew bake" ""  # files
offers "thew bake scene.toml" "--" --out --resume --no-render
offers "thew bake --bounds" "" fail warn
offers "thew render --progress" "" bar json
offers "thew golden" "" update check
offers "thew golden update" "--go" --golden
if command -v fish >/dev/null; then
  grep -q -e '^--bounds' <(fish -c "source $work/fish; complete -C 'thew bake --bou'") ||
    { echo "fish: thew bake --bou does not become --bounds"; failed=1; }
  grep -q '^warn' <(fish -c "source $work/fish; complete -C 'thew bake --bounds '") ||
    { echo "fish: thew bake --bounds does not offer warn"; failed=1; }
  grep -q '^update' <(fish -c "source $work/fish; complete -C 'thew golden '") ||
    { echo "fish: thew golden does not offer update"; failed=1; }
fi
if command -v zsh >/dev/null; then
  zsh -n "$work/zsh" || failed=1
  # The function's choices, with what would show them in place of zsh's own.
  cat >"$work/try.zsh" <<END
_describe() { print -l -- \${offered%%:*} }
_files() { print FILES }
compadd() { shift; print -l -- "\$@" }
_thew() { $(cat "$work/zsh") }
words=(thew bake --bounds ''); CURRENT=4; PREFIX=''; _thew
words=(thew golden ''); CURRENT=3; _thew
words=(thew bake --r); CURRENT=3; PREFIX=--r; _thew
words=(thew bake ''); CURRENT=3; PREFIX=''; _thew
END
  said=$(zsh -f "$work/try.zsh")
  for expected in warn update --resume FILES; do
    grep -qx -e "$expected" <<<"$said" || { echo "zsh: does not offer $expected"; failed=1; }
  done
fi
status=0
"$thew" --completion tcsh 2>/dev/null || status=$?
((status == 2)) || { echo "tcsh: ends with $status"; failed=1; }
# Each command and option that help names is on the manual page.
"$thew" --man >"$work/thew.1"
if command -v man >/dev/null; then
  warnings=$(man --warnings -l "$work/thew.1" 2>&1 >"$work/page")
  [[ -z $warnings ]] || { echo "$warnings"; failed=1; }
fi
for option in $("$thew" bake --help | grep -oE '^  --[a-z-]+' | sort -u); do
  grep -qF -- "${option//-/\\-}" "$work/thew.1" || { echo "thew.1: lacks $option"; failed=1; }
done
exit $failed
