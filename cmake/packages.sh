# Sourced by ./reproduce and ./check, from the top folder of the project.

# Root's folders are where dpkg looks for its helpers; a clean environment often lacks them.
export PATH="$PATH:/usr/local/sbin:/usr/sbin:/sbin"
export LC_ALL=C.UTF-8

# packages_of SECTION: the names listed under [SECTION] of packages.txt.
packages_of() {
  awk -v wanted="[$1]" '
    { sub(/#.*/, ""); gsub(/[ \t\r]/, "") }
    /^\[/ { inside = ($0 == wanted); next }
    inside && $0 != "" { print }' packages.txt
}

# install_packages SECTION... [--but NAME]: installs what these sections list, except NAME, and the machine lacks. Exits
# with 3 if that is not possible.
install_packages() {
  local section name but="" missing=() get=()
  if [ "$#" -gt 2 ] && [ "${*: -2:1}" = --but ]; then
    but="${*: -1}"
    set -- "${@:1:$#-2}"
  fi
  if ! command -v dpkg-query >/dev/null; then
    echo "This is no Debian system: make sure that what packages.txt lists is installed. Going on." >&2
    return 0
  fi
  for section in "$@"; do
    for name in $(packages_of "$section"); do
      if [ "$name" = "$but" ]; then continue; fi
      if [ "$(dpkg-query -W -f='${Status}' "$name" 2>/dev/null)" != "install ok installed" ]; then
        missing+=("$name")
      fi
    done
  done
  if [ "${#missing[@]}" -eq 0 ]; then return 0; fi

  if [ "$(id -u)" -ne 0 ]; then
    if command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
      get=(sudo -n)
    else
      {
        echo "Packages are missing, and installing them takes root, which this user cannot become. Run this, then start again:"
        echo "  sudo sh -c 'apt-get update && apt-get install --yes --no-install-recommends ${missing[*]}'"
      } >&2
      exit 3
    fi
  fi
  get+=(env DEBIAN_FRONTEND=noninteractive "PATH=$PATH" apt-get)
  echo "Installing ${missing[*]}"
  if ! "${get[@]}" update -qq || ! "${get[@]}" install --yes -qq --no-install-recommends "${missing[@]}"; then
    echo "apt-get could not install ${missing[*]}: see its message above, correct the cause and start again." >&2
    exit 3
  fi
}
