# Sourced by tests/layout/packages_test.cc, from the top folder of the project, after cmake/packages.sh: whether
# packages.txt brings what the sources name onto a system that has nothing yet. A developer's machine always has more.

# can_simulate: whether there is an apt-get that knows packages; says why if not.
can_simulate() {
  if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then echo "this is no Debian system" && return 1; fi
  if [[ "$(apt-cache policy g++ 2>/dev/null)" != *"Candidate: "[0-9]* ]]; then
    echo "apt-get knows no packages; apt-get update tells it" && return 1
  fi
}

# packages_brought FOLDER SECTION...: what apt-get would install for these sections onto an empty system, and what every
# Debian has before: essential and required packages. FOLDER keeps what apt-get has read for the next call, which takes
# seconds and must not become the cache of this machine.
packages_brought() {
  local empty="$1" section
  shift
  : >"$empty/status"
  # Nothing is installed, so this takes no lock and no root. Unlike a simulation (-s) it puts the packages into no order,
  # which takes twice as long as all else.
  apt-get -qq --print-uris -o Debug::NoLocking=1 -o Dir::State::status="$empty/status" \
    -o Dir::State::extended_states="$empty/none" -o Dir::Cache::pkgcache="$empty/pkgcache.bin" \
    -o Dir::Cache::srcpkgcache="$empty/srcpkgcache.bin" -o Dir::Cache::archives="$empty" install --no-install-recommends \
    $(for section in "$@"; do packages_of "$section"; done) >"$empty/files" 2>&1 || { cat "$empty/files" && return 1; } >&2
  awk '$1 ~ /^.[a-z]+:/ { sub(/_.*/, "", $2); print $2 }' "$empty/files"  # 'ADDRESS' NAME_VERSION_ARCHITECTURE.deb ...
  dpkg-query -W -f='${Package} ${Essential} ${Priority}\n' | awk '$2 == "yes" || $3 == "required" { print $1 }'
}

# files_named SOURCE...: "NAME FILE" for each header in <> and each program to start that these files name. What is not
# on this machine was not needed to build here, so it is left out; what lies in /usr/local belongs to no package.
files_named() {
  local name folders folder file
  folders=$(g++ -E -v -x c++ /dev/null 2>&1 | awk '/^#include </ { on = 1; next } /^End/ { on = 0 } on { print $1 }' |
    xargs readlink -f | grep -v '^/usr/local/')
  grep -hoE '^ *# *include *<[^>]+>' "$@" | sed 's/.*<//; s/>//' | sort -u | while read -r name; do
    for folder in $folders; do
      if [ -f "$folder/$name" ]; then echo "<$name> $(readlink -f "$folder/$name")" && continue 2; fi
    done
    # Folders that pkg-config adds: /usr/include/eigen3, /usr/include/hdf5/serial, .../openmpi/include.
    for file in /usr/include/*/"$name" /usr/include/*/*/"$name" /usr/lib/*/*/include/"$name"; do
      if [ -f "$file" ]; then echo "<$name> $(readlink -f "$file")"; fi
    done
  done
  grep -hoE '(find_(installed_)?program\(|note_version\(|arguments = \{|(run|output_of|succeeds)\(\{)"[a-z][a-z0-9_-]*"' "$@" |
    sed 's/.*("//; s/.*{"//; s/"//' | sort -u | while read -r name; do
    file=$(PATH=/usr/bin:/bin type -P -- "$name") || continue
    # One of several packages may give a program: gnuplot-nox, gnuplot-qt.
    { readlink -f "$file"; update-alternatives --list "$name" 2>/dev/null || true; } | sort -u | sed "s|^|$name |"
  done
}

# not_brought BROUGHT OPTIONAL SOURCE...: "NAME: PACKAGE" for each name in these files of which no package is listed in
# the file BROUGHT. OPTIONAL has the names that may lack, between blanks.
not_brought() {
  local brought="$1" optional="$2" named
  shift 2
  named=$(files_named "$@")
  # dpkg knows some files by their name from before /bin became /usr/bin.
  awk '{ print $2; sub(/^\/usr\//, "/", $2); print $2 }' <<<"$named" | sort -u | { xargs dpkg -S 2>/dev/null || true; } |
    awk -v optional=" $optional " -v brought="$brought" -v named="$named" '
      BEGIN { while ((getline package <brought) > 0) there[package] = 1 }
      /^diversion / { next }
      { file = $NF; sub(/^\/usr\//, "/", file); sub(/: \/.*/, ""); owner[file] = $0 }
      END {
        count = split(named, lines, "\n")
        for (i = 1; i <= count; ++i) {
          split(lines[i], part, " ")
          file = part[2]
          sub(/^\/usr\//, "/", file)
          if (!(file in owner)) continue
          owners[part[1]] = owners[part[1]] " " owner[file]
          n = split(owner[file], packages, ", ")
          for (k = 1; k <= n; ++k) {
            sub(/:.*/, "", packages[k])
            if (packages[k] in there) fine[part[1]] = 1
          }
        }
        for (name in owners) {
          ++seen
          if (!(name in fine) && !index(optional, " " name " ")) print name ":" owners[name]
        }
        if (seen < 20) print "only " seen + 0 " headers and programs have been looked at: the search is broken"
      }'
}
