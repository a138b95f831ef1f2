#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# One hash for every machine: tests/determinism/run.sh [--update] [--long] BUILD
# Bakes the scenes of hashes.txt with BUILD/tools/thew, by one thread and by two. --long: killed and
# resumed, more threads, other processors and places, and builds of the libraries alone
# (hash_bake.cpp) in BUILD, by both compilers from -O0 to -O3 and for this very processor. --update
# writes what BUILD/tools/thew gives as the new hashes, where the method has changed on purpose.
set -euo pipefail
here=$(cd -P -- "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")" >/dev/null && pwd)
source=$here/../..
update=no long=no
while [[ ${1-} == --* ]]; do
  case "$1" in
    --update) update=yes ;;
    --long) long=yes ;;
    *) echo "run.sh: unknown argument $1" >&2; exit 2 ;;
  esac
  shift
done
build=$(readlink -f "${1:?usage: run.sh [--update] [--long] BUILD}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0 count=0

# hash_of SCENE FRAMES COMMAND...: what COMMAND bakes of them
hash_of() {
  local scene=$1 frames=$2
  shift 2
  rm -rf "$work/out"
  "$@" bake "$source/$scene" --frames "$frames" --out "$work/out" --progress none \
    "${options[@]}" 2>"$work/errors" >/dev/null || { cat "$work/errors" >&2; return 1; }
  sed -n 's/^ *"hash": *"\([0-9a-f]*\)".*/\1/p' "$work/out/report.json"
}

# check NAME COMMAND...: all scenes (or those that match $only) against the list
check() {
  local name=$1 scene frames expected found
  shift
  while read -r scene frames expected; do
    [[ $scene == \#* || -z $scene || $scene != *$only* ]] && continue
    found=$(hash_of "$scene" "$frames" "$@") || found="no bake"
    count=$((count + 1))
    if [[ $found == "$expected" ]]; then
      echo "same       $name, $scene $frames"
    else
      echo "DIFFERENT  $name, $scene $frames: $found, not $expected"
      failed=1
    fi
  done <"$here/hashes.txt"
}

# second NAME COMPILER FLAGS: BUILD/NAME, checked
second() {
  cmake -S "$source" -B "$build/$1" -G Ninja -DCMAKE_CXX_COMPILER="$2" -DCMAKE_BUILD_TYPE=None \
    -DCMAKE_CXX_FLAGS="$3" -DTHEW_TOOLS=OFF -DTHEW_TESTS=OFF >"$work/log" &&
    cmake --build "$build/$1" --target hash_bake >>"$work/log" || { cat "$work/log" >&2; exit 1; }
  check "$2 $3" "$build/$1/tests/determinism/hash_bake"
}

only=
thew=$build/tools/thew
options=(--no-render --threads 1)
if [[ $update == yes ]]; then
  while read -r scene frames expected; do
    [[ $scene == \#* ]] || expected=$(hash_of "$scene" "$frames" "$thew")
    echo "$scene $frames $expected"
  done <"$here/hashes.txt" >"$work/hashes.txt"
  mv "$work/hashes.txt" "$here/hashes.txt"
  exit 0
fi

check "1 thread" "$thew"
options=(--no-render --threads 2)
check "2 threads" "$thew"

if [[ $long == yes ]]; then
  resumed() {  # killed after its first frame or some more
    local bake
    "$@" &
    bake=$!
    until [[ -s $work/out/bake.parts/manifest.jsonl ]] || ! kill -0 $bake 2>/dev/null; do
      sleep 0.01
    done
    kill -KILL $bake 2>/dev/null || true
    wait $bake || true
    "$@" --resume
  }
  check "killed and resumed" resumed "$thew"
  for threads in 4 8; do
    options=(--no-render --threads $threads)
    check "$threads threads" "$thew"
  done
  options=(--no-render --threads 2)
  for without in -AVX512F -AVX2,-FMA -AVX2,-FMA,-AVX,-SSE4_1; do
    check "a processor with $without" env GLIBC_TUNABLES=glibc.cpu.hwcaps=$without "$thew"
  done
  for locale in de_DE tr_TR; do
    # Made here where the system lacks it.
    if [[ -d /usr/share/i18n/locales ]] && mkdir -p "$work/locales" &&
      localedef -i $locale -f UTF-8 "$work/locales/$locale.UTF-8" 2>/dev/null; then
      check "locale $locale" env LOCPATH="$work/locales" LC_ALL=$locale.UTF-8 "$thew"
    else
      check "locale $locale (by name only)" env LC_ALL=$locale.UTF-8 "$thew"
    fi
  done
  check "a home that nobody can write to" env HOME=/proc XDG_CACHE_HOME=/proc "$thew"
  for zone in Pacific/Kiritimati America/Los_Angeles; do
    check "time zone $zone" env TZ=$zone "$thew"
  done
  closed() { "$@" <&-; }
  check "closed standard input" closed "$thew"
  options=(--threads 2)
  check "with pictures" "$thew"
  options=(--no-render --threads 2)
  for compiler in g++ clang++; do
    command -v $compiler >/dev/null || { echo "skipped    $compiler: not installed"; continue; }
    for flags in -O0 -O1 -O2 -O3 "-O2 -march=native" "-O3 -march=native"; do
      second "${compiler//+/x}${flags// /}" $compiler "$flags"
    done
  done
  if "$here/aarch64.sh" "$build/aarch64" >"$work/log" 2>&1; then
    only=pair  # emulation is slow
    check "AArch64, emulated" "$build/aarch64/hash_bake"
    only=
  else
    tail -n 1 "$work/log" >&2 || true
    echo "skipped    AArch64: it could not be built"
  fi
fi
echo "$count bakes compared"
exit $failed
