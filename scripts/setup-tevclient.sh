#!/usr/bin/env bash
# Fetches the Python client of the image viewer tev into the cache folder (<cache>/tevclient-VERSION, to be named in
# PYTHONPATH): tests compare what Sundog sends to tev with what it sends. It needs numpy, which bpy's Python has.

# shellcheck source=lib.sh
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

pins="$scripts/pins/tevclient.txt"
folder="$cache/tevclient-1.0.4"

is_complete() { [ -f "$folder/tevclient/packet.py" ]; }

is_complete && exit 0
lock_cache
is_complete && exit 0
rm -rf "$folder.new"
quietly "$(host_python)" -m pip --disable-pip-version-check --retries 2 install --quiet --no-deps --no-compile \
    --no-cache-dir --require-hashes --only-binary=:all: --target "$folder.new" -r "$pins" ||
    fail "tevclient could not be fetched from PyPI with its pinned hash: check the network, then run this again."
rm -rf "$folder"
mv "$folder.new" "$folder"
