#!/usr/bin/env bash
# Builds the Debian packages from an installation in staging folders; `make deb` calls it:
# packaging/deb.sh VERSION SOVERSION FOLDER
set -euo pipefail
cd "$(dirname "$0")/.."
version=$1 soversion=$2 folder=$3
architecture=$(dpkg --print-architecture)
libdir=/usr/lib/$(dpkg-architecture -qDEB_HOST_MULTIARCH)
runtime=libcylfuse$soversion
maintainer="the cylfuse developers <cylfuse@localhost>"
date=$(date -R -u -d "@${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || date +%s)}")

rm -rf "$folder"
mkdir -p "$folder"
folder=$(realpath "$folder")
make --no-print-directory install-runtime PREFIX=/usr LIBDIR="$libdir" DESTDIR="$folder/$runtime"
make --no-print-directory install-dev PREFIX=/usr LIBDIR="$libdir" DESTDIR="$folder/libcylfuse-dev"

# dpkg-shlibdeps wants to be in a source tree.
mkdir -p "$folder/source/debian"
printf 'Source: cylfuse\n\nPackage: %s\nArchitecture: any\n' "$runtime" > "$folder/source/debian/control"
depends=$(cd "$folder/source" && dpkg-shlibdeps -O "$folder/$runtime$libdir/libcylfuse.so.$version" | sed 's/^shlibs:Depends=//')
rm -r "$folder/source"

# control NAME DEPENDS SECTION SUMMARY: the text that both packages share, on standard input, follows the summary.
control() {
    local name=$1 staged=$folder/$1
    mkdir -p "$staged/DEBIAN" "$staged/usr/share/doc/$name"
    {
        printf 'Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\nUpstream-Name: cylfuse\n\n'
        printf 'Files: *\nCopyright: %s\nLicense: Expat or Apache-2.0\n\n' "$(sed -n 's/^Copyright (c) //p' LICENSE-MIT)"
        printf 'License: Expat\n'
        sed -n '/^Permission/,$ { s/^$/./; s/^/ /; p }' LICENSE-MIT
        printf '\nLicense: Apache-2.0\n The text is in /usr/share/common-licenses/Apache-2.0.\n'
    } > "$staged/usr/share/doc/$name/copyright"
    printf 'cylfuse (%s) unstable; urgency=medium\n\n  * What has changed is told by the release.\n\n -- %s  %s\n' \
        "$version" "$maintainer" "$date" | gzip -9n > "$staged/usr/share/doc/$name/changelog.gz"
    mkdir -p "$staged/usr/share/lintian/overrides"
    printf '# There is no address yet.\n%s: bogus-mail-host Maintainer *\n%s: bogus-mail-host-in-debian-changelog *\n' \
        "$name" "$name" > "$staged/usr/share/lintian/overrides/$name"
    {
        printf 'Package: %s\nSource: cylfuse\nVersion: %s\nArchitecture: %s\n' "$name" "$version" "$architecture"
        printf 'Multi-Arch: same\nMaintainer: %s\nDepends: %s\n' "$maintainer" "$2"
        printf 'Section: %s\nPriority: optional\nInstalled-Size: %s\n' "$3" "$(du -ks "$staged/usr" | cut -f 1)"
        printf 'Description: %s\n' "$4"
        printf ' Axis, radius and visible extent of a pipe, a can, a shaft or a trunk from depth\n'
        printf ' and the limb lines in the image, by a library with a C interface.\n'
    } > "$staged/DEBIAN/control"
    (cd "$staged" && find usr -type f -exec md5sum {} + | sort -k 2 > DEBIAN/md5sums)
}

control "$runtime" "$depends" libs "measures a cylinder from RGB-D views, shared library"
printf 'libcylfuse %s %s (>= %s)\n' "$soversion" "$runtime" "$version" > "$folder/$runtime/DEBIAN/shlibs"
printf 'activate-noawait ldconfig\n' > "$folder/$runtime/DEBIAN/triggers"
control libcylfuse-dev "$runtime (= $version)" libdevel "measures a cylinder from RGB-D views, development files"

for name in "$runtime" libcylfuse-dev; do
    dpkg-deb --root-owner-group --build "$folder/$name" "$folder/${name}_${version}_$architecture.deb"
    rm -r "${folder:?}/$name"
done
