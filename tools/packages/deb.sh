#!/bin/sh
# Write the files that a Debian package needs besides the installed ones.
# usage: deb.sh ROOT VERSION MAINTAINER
set -eu
root=$1 version=$2 maintainer=$3
doc=$root/usr/share/doc/bezel
for name in dpkg-deb:dpkg dpkg-shlibdeps:dpkg-dev; do
  command -v "${name%:*}" > /dev/null || { echo "make deb: missing: ${name%:*}; install it with 'apt install ${name#*:}'" >&2; exit 1; }
done
(cd "$root/.." && printf 'Source: bezel\n' > debian/control && dpkg-shlibdeps -O root/usr/bin/bezel 2> warnings) > "$root/../depends" ||
  { cat "$root/../warnings" >&2; exit 1; }
depends=$(sed -n 's/^shlibs:Depends=//p' "$root/../depends")
cat > "$root/DEBIAN/control" <<TEXT
Package: bezel
Version: $version
Architecture: $(dpkg --print-architecture)
Maintainer: $maintainer
Installed-Size: $(du -sk "$root/usr" | cut -f1)
Depends: $depends
Recommends: python3, python3-numpy, python3-h5py, python3-matplotlib
Section: science
Priority: optional
Description: finite elements for contact, friction and debonding of solids
 bezel solves 3-D solids at large deformations in contact, with friction, and
 with cohesive bonds that tear. It reads decks in the language of FEAP. A thin
 isogeometric layer makes the contact surface smooth, and plain elements fill
 the bulk. bezel-post plots and compares results.
TEXT
rm -f "$doc/LICENSE"
gzip -9n "$doc/CHANGELOG.md"
mv "$doc/CHANGELOG.md.gz" "$doc/changelog.gz"
gzip -9n > "$doc/changelog.Debian.gz" <<TEXT
bezel ($version) unstable; urgency=medium

  * Changes are listed in changelog.gz.

 -- $maintainer  $(LC_ALL=C date -u -R -d "@${SOURCE_DATE_EPOCH:-$(stat -c %Y CHANGELOG.md)}")
TEXT
{
  echo 'Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/'
  echo
  echo 'Files: *'
  echo "Copyright: $(sed -n 's/^Copyright (c) //p' LICENSE | head -n 1)"
  echo 'License: BSD-3-Clause'
  sed '1,/^Copyright/d' LICENSE | sed '/./,$!d; s/^$/./; s/^/ /'
} > "$doc/copyright"
mkdir -p "$root/usr/share/lintian/overrides"
# The first upload closes no request in Debian's bug tracker, because there is none.
echo 'bezel: initial-upload-closes-no-bugs' > "$root/usr/share/lintian/overrides/bezel"
find "$root/usr" -type d -exec chmod 755 {} +
chmod 644 "$doc"/copyright "$doc"/changelog*.gz
(cd "$root" && find usr -type f -exec md5sum {} + > DEBIAN/md5sums)
