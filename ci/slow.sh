#!/usr/bin/env bash
# The long measurements behind the README's tables, run by hand: about half an hour on 2 cores.
# usage: ci/slow.sh [small | real | agreement | threads]...   (default: all)
set -euo pipefail
cd "$(dirname "$0")/.."
python=${REACHTEST_VENV:-.venv-check}/bin/python
for part in "${@:-all}"; do
  "$python" ci/measure.py "$part"
done
