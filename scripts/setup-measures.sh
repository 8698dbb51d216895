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

require_supported_machine
pinned_venv "$cache/measures" "$scripts/pins/measures.txt" "$imports" "flip-evaluator, numpy and scikit-image" "400 MB"
