# Sourced by demo.sh and test.sh, from the top of the repository.
# install_packages GROUP: installs the Debian packages of cmake/packages.txt that are missing, those
# of the group (test, or "" for none) included.
install_packages() {
    command -v dpkg-query >/dev/null || {
        echo "not a Debian system: the packages of cmake/packages.txt are taken for granted"
        return 0
    }
    missing=
    while read -r package group; do
        case "$package" in '#'* | '') continue ;; esac
        [ -z "$group" ] || [ "$group" = "$1" ] || continue
        dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' ||
            missing="$missing $package"
    done <cmake/packages.txt
    [ -n "$missing" ] || return 0

    echo "installing:$missing"
    sudo=
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || {
            echo "needs root or sudo to install:$missing" >&2
            return 1
        }
        sudo=sudo
    fi
    $sudo apt-get -q update || echo "apt-get update failed; trying with the lists at hand" >&2
    # shellcheck disable=SC2086
    $sudo env DEBIAN_FRONTEND=noninteractive apt-get -qy install --no-install-recommends $missing </dev/null
}
