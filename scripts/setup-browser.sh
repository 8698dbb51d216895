#!/usr/bin/env bash
# Sets up what the tests of reports open pages with: Chromium from apt, and playwright, which drives it, as a virtual
# environment in the cache folder: <cache>/browser/bin/python. SUNDOG_CHROMIUM names another Chromium or Chrome.
# Where no Chromium can be had, that is said, and the tests that need it are skipped by name.

# shellcheck source=lib.sh
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

require_supported_machine
if [ -z "${SUNDOG_CHROMIUM:-}" ] && ! have chromium; then
    # (In a shell of its own: install_packages ends the one that it runs in if it fails.)
    (install_packages "to test reports in a browser" chromium fonts-dejavu-core) ||
        say "there is no Chromium on this machine: the tests of reports in a browser will be skipped"
fi
pinned_venv "$cache/browser" "$scripts/pins/browser.txt" "import playwright.sync_api, PIL.Image" "playwright" "200 MB"
