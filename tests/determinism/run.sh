#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# One hash for every machine: tests/determinism/run.sh [--update] [--long] BUILD
# Bakes the scenes of hashes.txt with BUILD/tools/thew, and with a second build of another compiler
# and optimisation in BUILD/second. --long: more builds, processors, threads, places. --update
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

# second NAME COMPILER FLAGS: BUILD/NAME/tools/thew
second() {
  cmake -S "$source" -B "$build/$1" -G Ninja -DCMAKE_CXX_COMPILER="$2" -DCMAKE_BUILD_TYPE=None \
    -DCMAKE_CXX_FLAGS="$3" -DTHEW_TESTS=OFF >"$work/log" &&
    cmake --build "$build/$1" --target thew >>"$work/log" || { cat "$work/log" >&2; exit 1; }
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
if command -v clang++ >/dev/null; then
  second second clang++ -O3
else
  second second g++ -O0
fi
check "second build, 2 threads" "$build/second/tools/thew"

if [[ $long == yes ]]; then
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
  check "no home" env HOME=/proc XDG_CACHE_HOME=/proc "$thew"
  check "other time zones" env TZ=Pacific/Kiritimati "$thew"
  closed() { "$@" <&-; }
  check "closed standard input" closed "$thew"
  options=(--threads 2)
  check "with pictures" "$thew"
  options=(--no-render --threads 2)
  second gcc_O0 g++ -O0 && check "g++ -O0" "$build/gcc_O0/tools/thew"
  second gcc_O3_native g++ "-O3 -march=native" &&
    check "g++ -O3 -march=native" "$build/gcc_O3_native/tools/thew"
  if command -v clang++ >/dev/null; then
    second clang_native clang++ "-O2 -march=native" &&
      check "clang++ -O2 -march=native" "$build/clang_native/tools/thew"
  fi
  if "$here/aarch64.sh" "$build/aarch64" >"$work/log" 2>&1; then
    only=pair  # emulation is slow
    check "AArch64, emulated" "$build/aarch64/thew"
    only=
  else
    tail -n 1 "$work/log" >&2 || true
    echo "skipped    AArch64: it could not be built"
  fi
fi
echo "$count bakes compared"
exit $failed
