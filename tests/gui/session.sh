#!/usr/bin/env bash
# Inside the folder that run.sh made: starts the window system and Blender, and ends with session.py's verdict.

set -u
mkdir -p "$HOME"
cd /session || exit 1
export DISPLAY=:77
Xvfb "$DISPLAY" -screen 0 1600x1000x24 >xvfb.txt 2>&1 &
server=$!
trap 'kill "$server" 2>/dev/null' EXIT
for _ in $(seq 50); do
    xdotool getmouselocation >/dev/null 2>&1 && break
    sleep 0.1
done
timeout 900 blender --factory-startup --python-exit-code 3 --window-geometry 0 0 1600 1000 --python session.py >log.txt 2>&1
status=$?
cat log.txt | grep '^GUI' || true
if grep -q '^GUI: all done' log.txt && ! grep -q '^GUI: FAILED' log.txt; then
    exit 0
fi
echo "the session did not succeed (Blender ended with $status); log.txt has what it said"
exit 1
