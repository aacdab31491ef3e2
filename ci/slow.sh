#!/usr/bin/env bash
# The long measurements behind the README's tables, run by hand: about an hour on 2 cores.
# usage: ci/slow.sh [small | real | agreement | threads | gym | items | navmesh | risk | unseen]...   (default: all)
set -euo pipefail
cd "$(dirname "$0")/.."
python=${REACHTEST_VENV:-.venv-check}/bin/python
for part in "${@:-all}"; do
  case $part in
    gym) "$python" ci/gym.py ;;
    items) "$python" ci/items.py ;;
    navmesh) "$python" ci/navmesh_table.py ;;
    risk) "$python" ci/risk.py ;;
    unseen) "$python" ci/unseen ;;
    all) "$python" ci/measure.py all && "$0" gym items navmesh risk unseen ;;
    *) "$python" ci/measure.py "$part" ;;
  esac
done
