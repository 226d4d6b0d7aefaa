# A bare Debian 12 in a folder, and what is tried there; sourced by scripts/package, whose check, fail and out it
# uses.

mirror=http://deb.debian.org/debian
root=$out/root

# Why nothing can be tried here, or nothing.
hindrance() {
  if [ "$(id -u)" -ne 0 ]; then
    echo "needs root, for a bare Debian 12 in a folder: sudo scripts/package"
  elif ! unshare --mount true 2>/dev/null; then
    echo "may not mount here: expected a machine, or a container that is privileged"
  elif [ ! -s "$out/bare.tar" ] &&
    ! mmdebstrap --quiet --variant=apt --include=ca-certificates bookworm "$out/bare.part.tar" "deb $mirror bookworm main" \
      >"$out/bare.log" 2>&1; then
    echo "no bare Debian 12 from $mirror: $(tail -n 1 "$out/bare.log")"
  fi
}

is_skipped() {
  local why
  why=$(hindrance)
  if [ -s "$out/bare.part.tar" ] && [ -z "$why" ]; then mv "$out/bare.part.tar" "$out/bare.tar"; fi
  [ -n "$why" ] || return 1
  echo "package: skipped: $why"
  skipped=$((skipped + 1))
}

# A command as root of the bare Debian, with its own mounts, which end with it. What apt fetches is kept.
in_root() {
  mkdir -p "$out/archives/partial"
  unshare --mount --pid --fork --kill-child bash -euc '
    root=$1 archives=$2
    shift 2
    mount --types proc proc "$root/proc"
    mount --types tmpfs -o mode=1777 shm "$root/dev/shm"
    mount --bind "$archives" "$root/var/cache/apt/archives"
    exec env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin DEBIAN_FRONTEND=noninteractive \
      LC_ALL=C.UTF-8 chroot "$root" "$@"' in_root "$root" "$out/archives" "$@"
}

# The CMake package that is installed in the bare Debian, used from here: there is no CMake there.
finds_by_cmake() {
  local folder=$out/cmake
  rm -rf "$folder"
  { cmake -S "$root/usr/share/stillgrid/examples/publish_ball" -B "$folder" -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_PREFIX_PATH="$root/usr" && cmake --build "$folder"; } >"$out/cmake.log" 2>&1 || {
    cat "$out/cmake.log"
    return 1
  }
}

try_in_bare_root() {
  if is_skipped; then return; fi
  rm -rf --one-file-system "$root"
  mkdir "$root"
  tar -xf "$out/bare.tar" -C "$root"
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  mkdir "$root/packages"
  cp "$out/debs"/*.deb scripts/packaging/try_packages scripts/packaging/completed "$root/packages"
  local line
  while IFS= read -r line; do
    case $line in
      "passed: "*) passed=$((passed + 1)) ;;
      "FAILED: "*) failed=$((failed + 1)) ;;
      "skipped: "*) skipped=$((skipped + 1)) ;;
      "ready for CMake") check "an engine finds libstillgrid by CMake" finds_by_cmake; : >"$root/packages/go_on" ;;
    esac
    echo "package: $line"
  done < <(in_root /packages/try_packages "$version" 2>&1 || echo "FAILED: it came to its end")
  rm -rf --one-file-system "$root"
}

run_piuparts() {
  if is_skipped; then return; fi
  gzip -c1 "$out/bare.tar" >"$out/bare.tar.gz"
  check "piuparts installs, upgrades and purges, and nothing is left" \
    piuparts --basetgz "$out/bare.tar.gz" --mirror "$mirror" --distribution bookworm --log-file "$out/piuparts.log" \
    --log-level error --warn-on-leftovers-after-purge "$out/debs"/*.deb
}
