#!/bin/sh
# Sets up a source tree: system packages, .venv, locked dependencies, the project itself.
# What is already there is left alone, so that it can be run before every command.
# Ends with exit code 1 and the one command to type where it may not install something.
#
#     installers/setup.sh [installer|ci]      with what only the building of installers, or CI, needs
set -eu
cd "$(dirname "$0")/.."

packages=installers/debian-packages.txt
lock=installers/requirements.lock
stamp=.venv/.installed
boris=.venv-boris
boris_lock=installers/boris.lock
case "${1:-}" in
    installer) comments='/^# CI/,$d; s/#.*//' ;;
    ci) comments='/^# Installer/,/^# CI/d; s/#.*//' ;;
    *) comments='/^# Installer/,$d; s/#.*//' ;;
esac

install_system_packages() {
    command -v dpkg-query >/dev/null 2>&1 || return 0  # not Debian: the user's own package manager
    missing=""
    # shellcheck disable=SC2013  # one word a line
    for package in $(sed "$comments" "$packages"); do
        status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
        [ "$status" = installed ] || missing="$missing $package"
    done
    [ -n "$missing" ] || return 0
    if [ "$(id -u)" = 0 ]; then
        as_root=""
    elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
        as_root="sudo -n"
    else
        echo "System packages are missing. Type this, then try again:" >&2
        echo "    sudo apt-get update && sudo apt-get install -y$missing" >&2
        exit 1
    fi
    echo "Installing system packages:$missing"
    $as_root apt-get -q update
    # shellcheck disable=SC2086  # both are lists of words
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get -q install -y --no-install-recommends $missing
}

find_python() {
    for candidate in "${PYTHON:-}" python3 python3.13 python3.12 python3.11; do
        [ -n "$candidate" ] || continue
        if "$candidate" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' \
            2>/dev/null; then
            echo "$candidate"
            return 0
        fi
    done
    echo "No Python 3.11, 3.12 or 3.13 was found. Type this, then try again:" >&2
    echo "    sudo apt-get update && sudo apt-get install -y python3 python3-venv" >&2
    return 1
}

make_environment() {
    [ -x "$1/bin/python" ] && return 0
    python=$(find_python)
    "$python" -m venv "$1"
}

# The lock is whole. Left to look for dependencies, an older pip meets "coverage[toml]" of
# pytest-cov, takes a release newer than the locked one, and refuses it for want of a hash.
install() {
    environment=$1
    shift
    "$environment/bin/python" -m pip install -q --disable-pip-version-check --no-deps "$@"
}

install_python_packages() {
    wanted=$(cat "$lock" pyproject.toml | cksum)
    [ "$(cat "$stamp" 2>/dev/null || true)" = "$wanted" ] && return 0
    make_environment .venv
    install .venv --require-hashes -r "$lock"
    install .venv --no-build-isolation -e .
    echo "$wanted" >"$stamp"
}

# BORIS, which tests let read what we write.
install_boris() {
    wanted=$(cksum <"$boris_lock")
    [ "$(cat "$boris/.installed" 2>/dev/null || true)" = "$wanted" ] && return 0
    make_environment "$boris"
    install "$boris" --require-hashes -r "$boris_lock"
    echo "$wanted" >"$boris/.installed"
}

install_system_packages
install_python_packages
[ "${1:-}" != ci ] || install_boris
