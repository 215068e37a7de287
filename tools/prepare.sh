# shellcheck shell=bash
# Sourced by quickstart.sh and test.sh: installs what a build and a run need where it is missing, and nothing else.

say() { printf '==> %s\n' "$*"; }
fail() {
    printf 'error: %s\n' "$*" >&2
    exit 1
}

# Installs Debian packages; sudo only for someone who is not root.
install() {
    if ! command -v apt-get >/dev/null; then
        fail "missing: $* (names of Debian packages). Install what corresponds to them on this system, then start again.
       Fedora: gcc vulkan-loader mesa-vulkan-drivers. Arch: gcc vulkan-icd-loader vulkan-swrast. macOS needs no driver."
    fi
    local root=()
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || fail "missing: $*. As root: apt-get install --no-install-recommends $*"
        root=(sudo)
    fi
    say "Installing $*"
    # Package lists may be absent or old; they are fetched only if they do not do.
    "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "$@" >/dev/null 2>&1 ||
        { "${root[@]}" apt-get update >/dev/null &&
            "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "$@" >/dev/null; } ||
        fail "could not install $*"
}

# Before the build: Rust, a C compiler (for the zstd library), and the Vulkan loader.
prepare_build() {
    if ! command -v cargo >/dev/null && [ -x "$HOME/.cargo/bin/cargo" ]; then
        PATH="$HOME/.cargo/bin:$PATH"
    fi
    command -v cargo >/dev/null || fail "no Rust toolchain: install Rust 1.95 or later from https://rustup.rs"
    if ! command -v cc >/dev/null; then
        if [ "$(uname -s)" = Darwin ]; then
            fail "no C compiler: run \`xcode-select --install\`"
        fi
        install gcc libc6-dev
    fi
    if [ "$(uname -s)" = Linux ] && ! has_loader; then
        install libvulkan1
    fi
}

has_loader() {
    local folder
    if { ldconfig -p || /sbin/ldconfig -p; } 2>/dev/null | grep -q 'libvulkan\.so\.1'; then
        return 0
    fi
    for folder in /usr/lib /usr/lib64 /usr/lib/*-linux-gnu /usr/local/lib; do
        if [ -e "$folder/libvulkan.so.1" ]; then
            return 0
        fi
    done
    return 1
}

# After the build: if squirm finds no adapter, the driver that computes on the CPU (Mesa's lavapipe).
prepare_adapter() {
    if [ -z "${XDG_RUNTIME_DIR:-}" ]; then
        # lavapipe complains without it.
        XDG_RUNTIME_DIR=$(mktemp -d)
        export XDG_RUNTIME_DIR
        trap 'rm -rf "$XDG_RUNTIME_DIR"' EXIT
    fi
    if ! usable; then
        if [ "$(uname -s)" != Linux ]; then
            fail "squirm finds no GPU on this machine"
        fi
        if compgen -G '/dev/nvidia[0-9]*' >/dev/null; then
            say "There is an NVIDIA GPU, but no Vulkan driver that answers: the package of its driver that holds libGLX_nvidia is missing"
        fi
        say "No GPU that squirm can use: it will compute on the CPU"
        install mesa-vulkan-drivers
        usable || fail "still no adapter: $("$squirm" adapters 2>&1)"
    fi
    say "Adapters:"
    "$squirm" adapters
}

usable() { "$squirm" adapters 2>/dev/null | grep -qv 'lacks features'; }

# The program where cargo puts it.
squirm="${CARGO_TARGET_DIR:-target}/release/squirm"
