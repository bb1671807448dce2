# To be sourced: packages of Debian, changed by one check at a time, for several run side by side.

# alone COMMAND...: runs it with the rights of root once no other check runs such a command.
alone() {
    local as_root=()
    [ "$(id -u)" = 0 ] || as_root=(sudo)
    flock "${TMPDIR:-/tmp}/cylfuse-packages-$(id -u)" "${as_root[@]}" "$@"
}

# install PACKAGE...: installs them.
install() {
    alone apt-get update -q
    alone env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "$@"
}

# require NAME PACKAGE [NAME PACKAGE...]: installs the packages whose commands or files are not there.
require() {
    local missing=()
    while [ $# -gt 0 ]; do
        [ -e "$1" ] || command -v "$1" >/dev/null || missing+=("$2")
        shift 2
    done
    [ ${#missing[@]} = 0 ] || install "${missing[@]}"
}
