#!/usr/bin/env bash
# The whole gate: sets up a virtual environment, then format, lint, strict types and tests.
# Property tests draw the same examples every time: a gate must not flake. Up to four processes share the tests, a file
# each at a time.
# Needs Python 3.11 or newer and nothing else. REACHTEST_VENV names another place for the environment.
set -euo pipefail
cd "$(dirname "$0")/.."
venv=${REACHTEST_VENV:-.venv-check}
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/pip" install --quiet --disable-pip-version-check -e '.[dev]'
"$venv/bin/ruff" format --check .
"$venv/bin/ruff" check .
"$venv/bin/mypy"
"$venv/bin/python" -m pytest --hypothesis-profile=ci -n auto --maxprocesses 4 --dist loadfile "$@"
