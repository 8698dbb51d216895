#!/usr/bin/env bash
# Sets up what the tests compare Sundog's measures with (PyPI's flip-evaluator, numpy and scikit-image), as a virtual
# environment in the cache folder: <cache>/measures/bin/python. SUNDOG_MEASURES_PYTHON names another Python that has them;
# then there is nothing to do.

# shellcheck source=lib.sh
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

imports='import flip_evaluator, numpy, skimage.metrics, OpenEXR, PIL.Image'
if [ -n "${SUNDOG_MEASURES_PYTHON:-}" ]; then
    "$SUNDOG_MEASURES_PYTHON" -c "$imports" >/dev/null 2>&1 ||
        fail "SUNDOG_MEASURES_PYTHON is $SUNDOG_MEASURES_PYTHON and that cannot import flip_evaluator, numpy, skimage, OpenEXR and PIL: correct the variable, or unset it and the set-up fetches them."
    exit 0
fi

pins="$scripts/pins/measures.txt"
venv="$cache/measures"

stamp() { sha256sum "$pins" | cut -d ' ' -f 1; }

is_complete() {
    [ "$(cat "$venv/stamp" 2>/dev/null)" = "$(stamp)" ] && works_as_python "$venv/bin/python"
}

require_supported_machine
is_complete && exit 0
lock_cache
is_complete && exit 0
host_python >/dev/null || install_packages "to fetch packages from PyPI" python3 python3-pip ca-certificates
python=$(python_3_11)

say "fetching flip-evaluator, numpy and scikit-image (80 MB) into $venv"
new="$venv.new"
rm -rf "$new"
"$python" -m venv --without-pip "$new" ||
    fail "$python cannot make a virtual environment in $new: see the message above."
quietly "$(host_python)" -m pip --disable-pip-version-check --retries 2 --python "$new/bin/python" install --quiet --no-deps \
    --no-compile --no-cache-dir --require-hashes --only-binary=:all: -r "$pins" ||
    fail "the measures' packages could not be fetched from PyPI with their pinned hashes: check the network and the room in $cache (400 MB), then run this again."
quietly "$new/bin/python" -c "$imports" ||
    fail "the measures' packages are there but cannot be imported on $(distribution): see the message above."
stamp >"$new/stamp"
rm -rf "$venv"
mv "$new" "$venv"
say "the measures' packages are ready"
