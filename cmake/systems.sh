# Sourced by ./check, from the top folder of the project: ./reproduce and the tests on new minimal systems, since the machine of a
# developer has packages that packages.txt may have forgotten.

releases=(bookworm trixie)

# sources_of RELEASE FOLDER: this machine's package sources for that release; none where it is no Debian, and then
# mmdebstrap takes Debian's own.
sources_of() {
  local id codename file
  id=$(. /etc/os-release && echo "${ID:-}")
  codename=$(. /etc/os-release && echo "${VERSION_CODENAME:-}")
  if [ "$id" != debian ] || [ -z "$codename" ]; then return 0; fi
  for file in /etc/apt/sources.list /etc/apt/sources.list.d/*.list /etc/apt/sources.list.d/*.sources; do
    if [ ! -f "$file" ] || ! grep -v '^ *#' "$file" | grep -w "$codename" >/dev/null; then continue; fi
    sed "s/\b$codename\b/$1/g" "$file" >"$2/${file##*/}"
    echo "$2/${file##*/}"
  done
}

# make_system RELEASE FOLDER: a minimal system in FOLDER/root that reaches packages the way this machine does.
make_system() {
  local sources
  mapfile -t sources < <(sources_of "$1" "$2")
  apt-config dump | grep -iE '^Acquire::(http|https|ftp)[:: ].*(Proxy|Ca|Ssl|Verify)' >"$2/apt.conf" || true
  mmdebstrap --quiet --mode=root --variant=minbase --aptopt="$2/apt.conf" "$1" "$2/root" "${sources[@]}" || return 1
  # Certificates of this machine, and those that the package ca-certificates adds to its own when it is installed.
  mkdir -p "$2/root/etc/ssl/certs" "$2/root/usr/local/share/ca-certificates"
  if [ -f /etc/ssl/certs/ca-certificates.crt ]; then cp -L /etc/ssl/certs/ca-certificates.crt "$2/root/etc/ssl/certs/"; fi
  if [ -d /usr/local/share/ca-certificates ]; then
    cp -rL /usr/local/share/ca-certificates/. "$2/root/usr/local/share/ca-certificates/"
  fi
  if [ -f /etc/resolv.conf ]; then cp -L /etc/resolv.conf /etc/hosts "$2/root/etc/"; fi
}

# in_system ROOT COMMAND: runs it in the project's folder there. What is mounted for it is gone when it ends, since no
# other process sees these mounts: a forgotten one would let rm reach this machine's /dev.
in_system() {
  unshare --mount --pid --fork --kill-child -- bash -euc '
    mount -t proc proc "$1/proc"
    mount --rbind /dev "$1/dev"
    mkdir -p "$1/dev/pts"
    exec env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root ${3:+"http_proxy=$3"} ${4:+"https_proxy=$4"} \
      chroot "$1" bash -c "cd /granuscope && $2"' \
    bash "$1" "$2" "${http_proxy:-}" "${https_proxy:-}"
}

# Few piles of few beads: whether everything is there shows before the minute of the quick experiment.
tiny_experiment() {
  printf '%s\n' '[lattice]' 'columns = 60' 'layers = 50' '[friction]' 'mu = [0.0, 0.3]' '[response]' 'samples = 256' \
    'blocks = 32' '[fit]' 'first_layer = 8' 'last_layer = 29' 'shallow_layer = 4' '[figures.response_profiles]' \
    'mu = 0.3' 'layers = [12, 24]'
}

# What is done in a system, step by step; what ./reproduce says of installing has to work, too.
steps=(
  "./reproduce --experiment /tmp/tiny.toml"
  "./reproduce"
  "cmake --build build/release && cmake --install build/release && granuscope doctor"
  ". cmake/packages.sh && install_packages run check"
  "cmake --preset release -DGRANUSCOPE_TESTS=ON && cmake --build --preset release"
  "ctest --preset release -L '^quick$' --no-tests=error --parallel 2"
)

# check_system RELEASE: sets `outcome`.
check_system() {
  local folder step
  folder=$(mktemp -d "${TMPDIR:-/tmp}/granuscope-system-XXXXXX")
  chmod 755 "$folder"  # apt-get fetches as a user of its own
  outcome=failed
  if ! make_system "$1" "$folder"; then
    outcome="skipped: mmdebstrap could not make it, see its message above"
  elif ! { mkdir "$folder/root/granuscope" && in_system "$folder/root" true 2>"$folder/said"; }; then
    outcome="skipped: no program can be run in it: $(tail -n 1 "$folder/said")"
  else
    git archive --prefix=granuscope/ HEAD | tar -x -C "$folder/root"
    tiny_experiment >"$folder/root/tmp/tiny.toml"
    outcome=passed
    for step in "${steps[@]}"; do
      echo "== $1: $step"
      if ! in_system "$folder/root" "$step"; then outcome="failed: $step" && break; fi
    done
  fi
  rm -rf --one-file-system "$folder"
}

# check_systems: one line for each release. Fails if one of them has failed.
check_systems() {
  local release outcome lines="" lacking=""
  if [ "$(id -u)" -ne 0 ]; then lacking="making a system takes root; run this as root"; fi
  if ! command -v mmdebstrap >/dev/null; then lacking="mmdebstrap is missing; apt-get install mmdebstrap"; fi
  for release in "${releases[@]}"; do
    echo "== what is committed, on a new $release"
    if [ -n "$lacking" ]; then outcome="skipped: $lacking"; else check_system "$release"; fi
    lines+="$release: $outcome"$'\n'
  done
  printf '\n%s' "$lines"
  [[ "$lines" != *": failed"* ]]
}
