# Sourced by ./aspic, ./test, ./bench/run and .ci/run. Installs the Debian packages that are missing
# and builds; says nothing when there is nothing to do.

aspic_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { printf '%s\n' "$*" >&2; }
die() { say "aspic: $*"; exit 1; }

# The packages under [$1] in packages.txt.
packages() {
    sed -n "/^\[$1\]/,/^\[/p" "$aspic_root/scripts/packages.txt" | grep -vE '^(\[|#|$)'
}

# Runs apt-get as root, through sudo where we are not.
apt() {
    local -a as_root=()
    if [ "$(id -u)" != 0 ]; then
        command -v sudo >/dev/null || die "packages are missing and neither root nor sudo is at hand: run as root: apt-get install $missing"
        as_root=(sudo)
    fi
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq "$@" </dev/null
}

# need_packages SECTION: installs what is missing of [SECTION]. A stamp holds the list that was last
# found whole, so that the usual case costs one comparison.
need_packages() {
    local stamp="$aspic_root/build/.packages-$1" list missing="" p log
    list=$(packages "$1" | tr '\n' ' ')
    if [ -f "$stamp" ] && [ "$(<"$stamp")" = "$list" ]; then return; fi
    command -v dpkg-query >/dev/null ||
        die "this is not a Debian system: install by hand what matches: $list"
    for p in $list; do
        [ "$(dpkg-query -W -f='${db:Status-Status}' "$p" 2>/dev/null)" = installed ] || missing+="$p "
    done
    mkdir -p "$aspic_root/build"
    if [ -n "$missing" ]; then
        say "Installing $missing"
        log="$aspic_root/build/apt-$1.log"
        # shellcheck disable=SC2086
        if ! apt install -y --no-install-recommends $missing >"$log" 2>&1; then
            apt update >>"$log" 2>&1 || say "(package lists could not be refreshed; see $log)"
            for p in $missing; do
                apt-cache show "$p" >/dev/null 2>&1 ||
                    die "the Debian package '$p' cannot be had: check the package sources of this machine"
            done
            # shellcheck disable=SC2086
            apt install -y --no-install-recommends $missing >>"$log" 2>&1 ||
                { tail -n 5 "$log" >&2; die "installing failed; the whole log is in $log"; }
        fi
    fi
    printf '%s' "$list" >"$stamp"
}

# build PRESET [TARGET ...]: configures once, then builds; quiet when there is nothing to do. One at a
# time: several programs started at once would write the same objects.
build() {
    mkdir -p "$aspic_root/build"
    (
        flock 9
        build_alone "$@"
    ) 9>"$aspic_root/build/.$1.lock"
}

build_alone() {
    local preset=$1 dir="$aspic_root/build/$1" log="$aspic_root/build/$1.log"
    shift
    if [ ! -f "$dir/build.ninja" ]; then
        say "Configuring ($preset)"
        (cd "$aspic_root" && cmake --preset "$preset") >"$log" 2>&1 ||
            { tail -n 20 "$log" >&2; die "configuring failed; see $log"; }
    fi
    # ninja prints one line when there is nothing to do; what is worth showing starts with a step.
    set +e
    NINJA_STATUS='[%f/%t, %es] ' ninja -C "$dir" "$@" 2>&1 9>&- | tee "$log" | show_build "$preset"
    local failed=${PIPESTATUS[0]}
    set -e
    [ "$failed" = 0 ] || { grep -m1 -A30 'FAILED' "$log" >&2 || tail -n 20 "$log" >&2; die "building failed; see $log"; }
}

# On a terminal one moving line, elsewhere one line in all; nothing for a build with no steps.
show_build() {
    local line started=""
    while IFS= read -r line; do
        [[ "$line" == *"] "*.o || "$line" == *"] Linking"* || "$line" == *"] Building"* ]] || continue
        [ -n "$started" ] || { say "Building ($1)"; started=1; }
        [ ! -t 2 ] || printf '\r\033[K%.78s' "$line" >&2
    done
    [ -z "$started" ] || [ ! -t 2 ] || printf '\r\033[K' >&2
}
