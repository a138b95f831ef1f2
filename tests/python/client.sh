#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# client.sh blender|types THEW SOURCE FOLDER: the module's tests in Blender's Python; its annotations,
# and those of the example, by mypy. Exits with 77 where the client is not installed.
set -euo pipefail
client=$1 thew=$2 source=$3 folder=$4
skip() { echo "skipped: $1"; exit 77; }
mkdir -p "$folder"
case "$client" in
  blender)
    command -v blender >/dev/null || skip "blender is not installed"
    # Blender hands its own words to no script: the test's stand in sys.argv when it is run.
    blender -b --factory-startup --python-exit-code 1 --python-expr "
import runpy, sys
sys.argv = ['module.py', *sys.argv[sys.argv.index('--') + 1:]]
sys.executable = '/usr/bin/python3'
try:
    runpy.run_path('$source/tests/python/module.py', run_name='__main__')
except SystemExit as end:
    assert not end.code, end.code
print('the tests have passed')" -- "$thew" "$source" "$folder" Bakes Reading Arrays Errors 2>&1 |
      tee "$folder/blender.txt"
    grep -q 'the tests have passed' "$folder/blender.txt" ;;
  types)
    command -v mypy >/dev/null || skip "mypy is not installed"
    mypy --strict --python-executable /usr/bin/python3 --cache-dir "$folder/mypy" \
      "$source/tools/python/thew"
    # Each name of the compiled module is in its stub, and no other.
    cat >"$folder/names.py" <<'END'
import ast, pathlib, sys, thew._thew as module
stub = ast.parse(pathlib.Path(sys.argv[1]).read_text())
def names(body):
    return {n.name if hasattr(n, "name") else n.target.id for n in body
            if isinstance(n, (ast.FunctionDef, ast.ClassDef, ast.AnnAssign))}
real = {n for n in dir(module) if not n.startswith("_")}
assert names(stub.body) == real, names(stub.body) ^ real
for one in stub.body:
    if isinstance(one, ast.ClassDef) and one.name != "Error":
        there = {n for n in vars(getattr(module, one.name)) if not n.startswith("_")}
        assert names(one.body) - {"__init__"} == there, (one.name, names(one.body) ^ there)
END
    /usr/bin/python3 "$folder/names.py" "$source/tools/python/thew/_thew.pyi" ;;
esac
