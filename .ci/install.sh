#!/bin/sh
# Installs the ilon command: fetches the archive of a release for this machine, holds it against its checksum, and puts the command, its
# C library and its completions below ~/.local, or where ILON_PREFIX says. Nothing else is touched. ILON_RELEASE names a release by its address.
set -eu

release="${ILON_RELEASE:-@RELEASE@}"
prefix="${ILON_PREFIX:-$HOME/.local}"

fail() { printf 'ilon was not installed: %s\n' "$1" >&2; exit 1; }

case "$(uname -s) $(uname -m)" in
  "Linux x86_64")                 host=x86_64-unknown-linux-gnu ;;
  "Linux aarch64"|"Linux arm64")  host=aarch64-unknown-linux-gnu ;;
  "Darwin arm64")                 host=aarch64-apple-darwin ;;
  *) fail "there is no archive for $(uname -s) on $(uname -m); build it from its sources: cargo install --locked --path crates/doors/ilon" ;;
esac
case "$release" in
  */*) ;;
  *) fail "ILON_RELEASE names no release, such as https://HOST/OWNER/ilon/releases/download/v0.1.0" ;;
esac
name="ilon-${release##*/}-$host"

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fetch() {
  if command -v curl >/dev/null; then curl -fsSL "$release/$1" -o "$folder/$1"
  elif command -v wget >/dev/null; then wget -q "$release/$1" -O "$folder/$1"
  else fail "neither curl nor wget is here"
  fi || fail "$release/$1 cannot be fetched"
}
fetch "$name.tar.gz"
fetch "$name.tar.gz.sha256"
cd "$folder"
if command -v sha256sum >/dev/null; then sha256sum -c "$name.tar.gz.sha256" >/dev/null 2>&1
else shasum -a 256 -c "$name.tar.gz.sha256" >/dev/null 2>&1
fi || fail "$name.tar.gz is not the file of its checksum; fetch it again"
tar xzf "$name.tar.gz"
"./$name/ilon" --version >/dev/null || fail "the command does not run on this machine"

mkdir -p "$prefix/bin" "$prefix/lib" "$prefix/include" "$prefix/share/bash-completion/completions" "$prefix/share/zsh/site-functions" \
  "$prefix/share/fish/vendor_completions.d" "$prefix/share/man/man1"
cp "$name/ilon" "$prefix/bin/ilon.new"
mv "$prefix/bin/ilon.new" "$prefix/bin/ilon"
for library in "$name"/lib/*; do
  cp "$library" "$prefix/lib/new.${library##*/}"
  mv "$prefix/lib/new.${library##*/}" "$prefix/lib/${library##*/}"
done
cp "$name"/include/* "$prefix/include/"
cp "$name/completions/ilon.bash" "$prefix/share/bash-completion/completions/ilon"
cp "$name/completions/_ilon" "$prefix/share/zsh/site-functions/_ilon"
cp "$name/completions/ilon.fish" "$prefix/share/fish/vendor_completions.d/ilon.fish"
cp "$name"/man/*.1 "$prefix/share/man/man1/"
printf '%s is in %s/bin\n' "$("$prefix/bin/ilon" --version)" "$prefix"
case ":$PATH:" in
  *":$prefix/bin:"*) printf 'try: ilon demo\n' ;;
  *) printf 'add it to your PATH: export PATH="%s/bin:$PATH"\n' "$prefix" ;;
esac
