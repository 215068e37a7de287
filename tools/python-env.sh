# shellcheck shell=bash
# Sourced by scripts that test Python readers: one virtual environment below target, filled with what is missing in it.

# Makes target/python-venv if it is not there, installs the given PACKAGE==VERSION... and sets $python to its interpreter.
python_env() {
    local base=${CARGO_TARGET_DIR:-target}/python-venv marker wanted
    command -v python3 >/dev/null || {
        printf 'error: python3 is missing; on Debian: apt-get install python3 python3-venv\n' >&2
        return 1
    }
    if [ ! -x "$base/bin/python" ]; then
        python3 -m venv "$base" || {
            printf 'error: cannot make a virtual environment in %s; on Debian: apt-get install python3-venv\n' "$base" >&2
            return 1
        }
    fi
    python=$base/bin/python
    for wanted in "$@"; do
        # A file for each installed requirement keeps a second call from asking the registry again.
        marker=$base/installed-${wanted//[^A-Za-z0-9.=-]/_}
        if [ ! -e "$marker" ]; then
            "$python" -m pip install --quiet --disable-pip-version-check "$wanted" || return 1
            : >"$marker"
        fi
    done
}
